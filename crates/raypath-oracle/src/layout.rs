//! The meaning of each word of a job.

use raypath_model::WordModel;

/// The fields of each operation's jobs, in the order of the words.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    /// The operations' names, in the order of their opcodes, with the fields of their jobs.
    operations: Vec<(&'static str, Vec<Field>)>,
}

/// The meaning of a word. Axes are 0 to 2.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Field {
    /// A coordinate of the ray's origin.
    Origin(usize),
    /// A coordinate of the ray's direction.
    Direction(usize),
    /// A coordinate of the ray's inverse direction.
    Inverse(usize),
    /// The ray's extent.
    Extent,
    /// A shear factor: Sx, Sy or Sz.
    Shear(usize),
    /// An axis index, kx, ky or kz: no number.
    Axis(usize),
    /// A bound of a box.
    Bound {
        /// The box, 0 to 7.
        index: usize,
        /// The axis.
        axis: usize,
        /// Whether it is the upper bound.
        is_max: bool,
    },
    /// A coordinate of a triangle's vertex.
    Vertex {
        /// The vertex, 0 to 2.
        vertex: usize,
        /// The axis.
        axis: usize,
    },
    /// A coordinate of a vector.
    Lane {
        /// Whether it belongs to the candidate, not to the query.
        of_candidate: bool,
        /// The lane.
        lane: usize,
    },
    /// The least distance of a hit.
    TMin,
    /// The mask of enabled lanes: no number.
    Mask,
    /// Whether the beat is its vector's last: no number.
    Reset,
    /// The index of an accumulator: no number.
    Accumulator,
    /// The tag: no number.
    Tag,
    /// A key.
    Key,
    /// A separator of a node's keys.
    Separator(usize),
    /// A coordinate of a point.
    Point(usize),
    /// A coordinate of a compressed node's origin.
    NodeOrigin(usize),
    /// A scale of a compressed node.
    NodeScale(usize),
    /// A bound of a child in a compressed node: no number.
    Offset {
        /// The child, 0 to 3.
        child: usize,
        /// The axis.
        axis: usize,
        /// Whether it is the upper bound.
        is_max: bool,
    },
    /// Which children of a compressed node are used: no number.
    Used,
    /// A coordinate of a sphere's centre.
    Centre(usize),
    /// A sphere's radius.
    Radius,
    /// A port of unknown meaning.
    Unknown,
}

impl Layout {
    /// The layout of a model's jobs.
    pub fn of(model: &WordModel) -> Self {
        let fields = |kind| model.inputs(kind).iter().map(|port| Field::of(&port.name)).collect();
        Self { operations: model.kinds().into_iter().map(|kind| (kind.name(), fields(kind))).collect() }
    }

    /// The fields of the jobs of the operation of this name; none if there is no such operation.
    pub fn fields(&self, name: &str) -> &[Field] {
        self.operations.iter().find(|(known, _)| *known == name).map_or(&[], |(_, fields)| fields)
    }
}

impl Field {
    /// Whether the word is a number.
    pub fn is_number(self) -> bool {
        let is_word = matches!(self, Self::Axis(_) | Self::Mask | Self::Reset | Self::Accumulator | Self::Tag);
        !(is_word || matches!(self, Self::Offset { .. } | Self::Used | Self::Unknown))
    }

    /// The field of a port, by the port's name.
    fn of(port: &str) -> Self {
        let one_of = |names: &str, name: &str| names.split(' ').position(|known| known == name);
        let axis = |name: &str| one_of("x y z", name);
        let parts: Vec<&str> = port.split('_').collect();
        let field = match parts.as_slice() {
            ["t", "min"] => Some(Self::TMin),
            ["accumulator"] => Some(Self::Accumulator),
            ["tag"] => Some(Self::Tag),
            ["key"] => Some(Self::Key),
            ["separator", index] => index.parse().ok().map(Self::Separator),
            ["point", name] => axis(name).map(Self::Point),
            ["node", "origin", name] => axis(name).map(Self::NodeOrigin),
            ["node", "scale", name] => axis(name).map(Self::NodeScale),
            ["node", "child", child, name, bound] => child.parse().ok().zip(axis(name)).map(|(child, axis)| {
                let is_max = *bound == "max";
                Self::Offset { child, axis, is_max }
            }),
            ["node", "used"] => Some(Self::Used),
            ["sphere", "centre", name] => axis(name).map(Self::Centre),
            ["sphere", "radius"] => Some(Self::Radius),
            ["ray", "origin", name] => axis(name).map(Self::Origin),
            ["ray", "dir", name] => axis(name).map(Self::Direction),
            ["ray", "inv", name] => axis(name).map(Self::Inverse),
            ["ray", "shear", name] => axis(name).map(Self::Shear),
            ["ray", "extent"] => Some(Self::Extent),
            ["ray", name] => one_of("kx ky kz", name).map(Self::Axis),
            ["aabb", index, name, bound] => index.parse().ok().zip(axis(name)).map(|(index, axis)| {
                let is_max = *bound == "max";
                Self::Bound { index, axis, is_max }
            }),
            ["triangle", vertex, name] => {
                one_of("a b c", vertex).zip(axis(name)).map(|(vertex, axis)| Self::Vertex { vertex, axis })
            }
            ["euclidean", "mask"] => Some(Self::Mask),
            ["euclidean", "reset", "accum"] => Some(Self::Reset),
            ["euclidean", vector, lane] => {
                lane.parse().ok().map(|lane| Self::Lane { of_candidate: *vector == "b", lane })
            }
            _ => None,
        };
        field.unwrap_or(Self::Unknown)
    }
}
