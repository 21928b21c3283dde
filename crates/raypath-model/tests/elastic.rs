//! A row of skid buffers, against what `docs/ports.md` promises of it.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use raypath_model::{Elastic, Transfer};
use std::collections::VecDeque;

/// Random sources and sinks: nothing lost, repeated or reordered; outputs hold; never more than 2 N inside, and room
/// for as many; nothing leaves sooner than N cycles after it entered.
fn obeys_the_handshake<const N: usize>() {
    for seed in 0..40 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut pipeline = Elastic::<u64, N>::new();
        let mut inside: VecDeque<(u64, u64)> = VecDeque::new();
        let (mut source_mood, mut sink_mood) = (0.5, 0.5);
        let mut held = None;
        let (mut next, mut fullest, mut was_empty) = (0, 0, 0);
        for cycle in 0..4000 {
            if rng.random_bool(0.02) {
                source_mood = [0.0, 0.1, 0.5, 1.0][rng.random_range(0..4)];
                sink_mood = [0.0, 0.1, 0.5, 1.0][rng.random_range(0..4)];
            }
            if rng.random_bool(0.001) {
                pipeline.reset();
                (held, _) = (None, inside.clear());
            }
            let (input, output_ready) = (rng.random_bool(source_mood).then_some(next), rng.random_bool(sink_mood));
            let (ready, shown) = (pipeline.input_ready(), pipeline.output().copied());
            if let Some(item) = held {
                assert_eq!(shown, Some(item), "cycle {cycle}: an output holds until it is taken");
            }
            if let Some(item) = shown {
                let (oldest, entered) = *inside.front().expect("nothing comes from an empty pipeline");
                assert_eq!(item, oldest, "cycle {cycle}");
                assert!(cycle - entered >= N as u64, "cycle {cycle}: item {item} entered at {entered}");
            }
            let Transfer { accepted, output } = pipeline.cycle(input, output_ready);
            assert_eq!(accepted, input.is_some() && ready);
            assert_eq!(output, shown.filter(|_| output_ready));
            held = shown.filter(|_| !output_ready);
            if output.is_some() {
                inside.pop_front();
            }
            if accepted {
                inside.push_back((next, cycle));
                next += 1;
            }
            fullest = fullest.max(inside.len());
            was_empty += usize::from(inside.is_empty());
            assert!(inside.len() <= 2 * N);
        }
        assert!(next > 200 && fullest == 2 * N && was_empty > 0, "seed {seed}: {next} {fullest} {was_empty}");
    }
}

#[test]
fn rows_of_any_length_obey_the_handshake() {
    obeys_the_handshake::<1>();
    obeys_the_handshake::<2>();
    obeys_the_handshake::<3>();
    obeys_the_handshake::<12>();
}

#[test]
fn an_item_takes_n_cycles_and_one_follows_another() {
    let mut pipeline = Elastic::<usize, 12>::new();
    for cycle in 0..200_usize {
        assert!(pipeline.input_ready());
        assert_eq!(pipeline.output().copied(), cycle.checked_sub(12));
        pipeline.cycle(Some(cycle), true);
    }
}

/// Ready is a register: it says what was true before this cycle's transfer.
#[test]
fn a_full_row_accepts_again_one_cycle_after_its_first_buffer_gave() {
    let mut one = Elastic::<u8, 1>::new();
    assert!(one.cycle(Some(1), false).accepted);
    assert!(one.cycle(Some(2), false).accepted);
    assert!(!one.cycle(Some(3), false).accepted, "both registers are full");
    assert_eq!(one.cycle(Some(3), true), Transfer { accepted: false, output: Some(1) }, "though one leaves");
    assert_eq!(one.cycle(Some(3), true), Transfer { accepted: true, output: Some(2) });
    assert_eq!(one.output(), Some(&3));
}
