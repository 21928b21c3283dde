//! The operands of a job, by their meaning.

use super::number::{Arithmetic, Number};
use crate::layout::Field;

/// Two bounds.
#[derive(Debug, Clone, Copy)]
pub struct Slab<T> {
    pub min: T,
    pub max: T,
}

impl<T> Slab<T> {
    fn bound(&mut self, is_max: bool) -> &mut T {
        if is_max { &mut self.max } else { &mut self.min }
    }
}

/// The operands of a job of any operation. Those that its operation lacks have no meaning.
#[derive(Debug)]
pub struct Inputs {
    pub origin: [Number; 3],
    pub direction: [Number; 3],
    pub inverse: [Number; 3],
    pub extent: Number,
    pub shear: [Number; 3],
    /// kx, ky and kz; an index of 3 reads z.
    pub axes: [usize; 3],
    pub boxes: Vec<[Slab<Number>; 3]>,
    pub vertices: [[Number; 3]; 3],
    pub t_min: Number,
    /// The lanes of query and candidate.
    pub query: Vec<Number>,
    pub candidate: Vec<Number>,
    pub mask: u64,
    pub is_last: bool,
    pub accumulator: usize,
    pub tag: u64,
    pub key: Number,
    pub separators: Vec<Number>,
    pub point: [Number; 3],
    pub node_origin: [Number; 3],
    pub node_scale: [Number; 3],
    pub offsets: [[Slab<u64>; 3]; 4],
    pub used: u64,
    pub centre: [Number; 3],
    pub radius: Number,
}

impl Inputs {
    /// Reads the words of a job.
    pub fn read(fields: &[Field], words: &[u64], arithmetic: &Arithmetic) -> Self {
        let (zero, zeros) = (Number::ZERO, [Number::ZERO; 3]);
        let mut inputs = Self {
            origin: zeros,
            direction: zeros,
            inverse: zeros,
            extent: zero,
            shear: zeros,
            axes: [0; 3],
            boxes: Vec::new(),
            vertices: [zeros; 3],
            t_min: zero,
            query: Vec::new(),
            candidate: Vec::new(),
            mask: 0,
            is_last: false,
            accumulator: 0,
            tag: 0,
            key: zero,
            separators: Vec::new(),
            point: zeros,
            node_origin: zeros,
            node_scale: zeros,
            offsets: [[Slab { min: 0, max: 0 }; 3]; 4],
            used: 0,
            centre: zeros,
            radius: zero,
        };
        for (&field, &word) in fields.iter().zip(words) {
            let number = arithmetic.number(word);
            match field {
                Field::Origin(axis) => inputs.origin[axis] = number,
                Field::Direction(axis) => inputs.direction[axis] = number,
                Field::Inverse(axis) => inputs.inverse[axis] = number,
                Field::Extent => inputs.extent = number,
                Field::Shear(axis) => inputs.shear[axis] = number,
                Field::Axis(axis) => inputs.axes[axis] = (word as usize & 3).min(2),
                Field::Bound { index, axis, is_max } => {
                    if inputs.boxes.len() <= index {
                        inputs.boxes.resize(index + 1, [Slab { min: zero, max: zero }; 3]);
                    }
                    *inputs.boxes[index][axis].bound(is_max) = number;
                }
                Field::Vertex { vertex, axis } => inputs.vertices[vertex][axis] = number,
                Field::TMin => inputs.t_min = number,
                Field::Lane { of_candidate: true, .. } => inputs.candidate.push(number),
                Field::Lane { of_candidate: false, .. } => inputs.query.push(number),
                Field::Mask => inputs.mask = word,
                Field::Reset => inputs.is_last = word & 1 == 1,
                Field::Accumulator => inputs.accumulator = word as usize,
                Field::Tag => inputs.tag = word,
                Field::Key => inputs.key = number,
                Field::Separator(_) => inputs.separators.push(number),
                Field::Point(axis) => inputs.point[axis] = number,
                Field::NodeOrigin(axis) => inputs.node_origin[axis] = number,
                Field::NodeScale(axis) => inputs.node_scale[axis] = number,
                Field::Offset { child, axis, is_max } => *inputs.offsets[child][axis].bound(is_max) = word,
                Field::Used => inputs.used = word,
                Field::Centre(axis) => inputs.centre[axis] = number,
                Field::Radius => inputs.radius = number,
                Field::Unknown => {}
            }
        }
        inputs
    }
}
