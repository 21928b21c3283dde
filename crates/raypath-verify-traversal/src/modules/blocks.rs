//! The blocks that the memory returns.

use super::{Bench, CYCLES};
use rand::RngExt;
use raypath_traversal::blocks::NodeKind;

/// The bits of a child word that say its kind; a child of kind 0 does not exist.
const KIND: u64 = 0x3f;

/// What a context has: the words that have arrived so far, and whether one of their beats had an error.
#[derive(Clone)]
struct Block {
    words: Vec<u64>,
    beats: usize,
    has_error: bool,
    is_whole: bool,
}

/// A reader: its ports in, and for each port out the word of the block, and whether the port says that it is a child.
struct Reader {
    read: usize,
    context: usize,
    ports: Vec<(usize, usize, bool)>,
    /// The words at its ports, since the first read of a whole block.
    shown: Option<Vec<u64>>,
}

/// Compares arrivals, and the words that readers see, of blocks whose beats come in any order. A block is read from the
/// cycle after its last beat on, until its context has another beat.
pub fn run(bench: &mut Bench, contexts: u32, node: NodeKind) -> Result<(), String> {
    let [valid, context, error, data] = bench.inputs(["valid_i", "context_i", "error_i", "data_0_i"]);
    let [arrived, failed] = bench.outputs(["arrived_o", "failed_o"]);
    let per_beat = (0..).take_while(|word| bench.input(&format!("data_{word}_i")).is_some()).count();
    let beats = node.block_bytes() as usize / 4 / per_beat;
    let mut readers = readers(bench, node);
    let new = Block { words: vec![0; beats * per_beat], beats: 0, has_error: false, is_whole: false };
    let mut blocks = vec![new; contexts as usize];
    for cycle in 0..CYCLES {
        let mut words = bench.words();
        let (is_valid, here) = (!bench.chance(4), bench.random.random_range(0..contexts as usize));
        (words[valid], words[context], words[error]) = (is_valid.into(), here as u64, bench.chance(8).into());
        let whole: Vec<usize> =
            (0..blocks.len()).filter(|&number| blocks[number].is_whole && !(is_valid && number == here)).collect();
        for reader in &mut readers {
            let is_read = !whole.is_empty() && bench.chance(2);
            words[reader.read] = is_read.into();
            if is_read {
                let number = whole[bench.random.random_range(0..whole.len())];
                words[reader.context] = number as u64;
            }
        }
        words.iter().enumerate().for_each(|(input, &word)| bench.set(input, word));
        bench.simulator.settle();

        for Reader { ports, shown, .. } in &readers {
            let found: Vec<u64> = ports.iter().map(|&(output, ..)| bench.get(output)).collect();
            if shown.as_ref().is_some_and(|shown| *shown != found) {
                return Err(format!("cycle {cycle}: found {found:x?}, expected {shown:x?}"));
            }
        }
        let block = &mut blocks[here];
        let is_last = is_valid && block.beats + 1 == beats;
        let has_error = block.has_error || words[error] == 1;
        let found = [bench.get(arrived), bench.get(failed)].map(|bit| bit == 1);
        if found[0] != is_last || is_last && found[1] != has_error {
            return Err(format!(
                "cycle {cycle}: arrived and failed are {found:?}, expected {:?}",
                [is_last, has_error]
            ));
        }
        for Reader { read, context, ports, shown } in &mut readers {
            if words[*read] == 1 {
                let block = &blocks[words[*context] as usize].words;
                let seen = |&(_, word, is_child): &(usize, usize, bool)| {
                    if is_child { u64::from(block[word] & KIND != 0) } else { block[word] }
                };
                *shown = Some(ports.iter().map(seen).collect());
            }
        }
        if is_valid {
            let block = &mut blocks[here];
            block.words[block.beats * per_beat..][..per_beat].copy_from_slice(&words[data..][..per_beat]);
            block.is_whole = is_last;
            block.beats = if is_last { 0 } else { block.beats + 1 };
            block.has_error = has_error && !is_last;
        }
        bench.simulator.cycle();
    }
    Ok(())
}

/// The readers, and the places of their words in a block.
fn readers(bench: &Bench, node: NodeKind) -> Vec<Reader> {
    let of = [
        ("job", vec![("word", 0, false), ("exists", node.child_word(), true)]),
        ("child", vec![("child", node.child_word(), false)]),
        ("index", vec![("index", node.index_word(), false)]),
    ];
    let reader = |(reader, titles): (&str, Vec<(&str, usize, bool)>)| {
        let ports = titles.into_iter().flat_map(|(title, first, is_child)| {
            (0..).map_while(move |k| Some((bench.output(&format!("{title}_{k}_o"))?, first + k, is_child)))
        });
        let [read, context] = ["read", "context"].map(|what| bench.input(&format!("{reader}_{what}_i")));
        Some(Reader { read: read?, context: context?, ports: ports.collect(), shown: None })
    };
    of.into_iter().filter_map(reader).collect()
}
