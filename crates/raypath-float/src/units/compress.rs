//! Carry-save addition: reduces many words to two with the same sum, without carry propagation.
//!
//! A compressor is a row of full adders: it replaces three rows by their sum without carries and their carries. Columns
//! that only two rows have reached are left as they are.

use raypath_hdl::Wire;

/// A word to be added; its lowest bit is in column `low`.
#[derive(Clone, Copy)]
pub(crate) struct Row<'m> {
    pub word: Wire<'m>,
    pub low: u32,
}

impl<'m> Row<'m> {
    /// The column above its highest bit.
    fn end(self) -> u32 {
        self.low + self.word.width()
    }

    /// The columns from `low` to below `end`, zeros where the row has none.
    pub fn columns(self, low: u32, end: u32) -> Wire<'m> {
        let m = self.word.builder();
        let (from, to) = (self.low.max(low), self.end().min(end));
        if from >= to {
            return m.constant(end - low, 0);
        }
        let bits = self.word.bits(to - 1 - self.low, from - self.low);
        let right = if from > low { m.concat(&[bits, m.constant(from - low, 0)]) } else { bits };
        right.extend(end - low)
    }
}

/// At most two rows with the same sum, modulo two to the number of `columns`.
pub(crate) fn compress(mut rows: Vec<Row<'_>>, columns: u32) -> Vec<Row<'_>> {
    let mut index = 0;
    while rows.len() > 2 {
        rows = rows
            .chunks(3)
            .flat_map(|chunk| match *chunk {
                [a, b, c] => {
                    index += 1;
                    full_adders([a, b, c], columns, index - 1)
                }
                _ => chunk.to_vec(),
            })
            .collect();
    }
    rows
}

fn full_adders<'m>(mut rows: [Row<'m>; 3], columns: u32, index: u32) -> Vec<Row<'m>> {
    rows.sort_by_key(|row| row.low);
    let [a, b, c] = rows;
    let m = a.word.builder();
    let low = c.low;
    let mut ends = rows.map(|row| row.end().min(columns));
    ends.sort();
    let [_, carry_end, end] = ends;
    let names = ["x", "y", "z"].map(|name| format!("{name}_{index}"));
    let [x, y, z] = [0, 1, 2].map(|row| rows[row].columns(low, end).named(&names[row]));
    let differ = (x ^ z).named(&format!("differ_{index}"));
    let sum = differ ^ y;
    let carry_end = (carry_end + 1).min(columns);
    let width = carry_end - 1 - low;
    let carry = (differ.lower(width) & y.lower(width)) | (!differ.lower(width) & x.lower(width));
    let carry = carry.named(&format!("carry_out_{index}"));
    let below = |row: Row<'m>| if row.low < low { vec![row.columns(row.low, low)] } else { vec![] };
    let sum = [vec![sum], below(a)].concat();
    let carry = [vec![carry, m.constant(1, 0)], below(b)].concat();
    vec![
        Row { word: m.concat(&sum).named(&format!("sum_{index}")), low: a.low },
        Row { word: m.concat(&carry).named(&format!("carry_{index}")), low: b.low },
    ]
}
