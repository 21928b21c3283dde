//! The meaning of each word of a job.

use raypath_model::WordModel;
use raypath_ops::JobKind;

/// The fields of each operation's jobs, in the order of the words.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    fields: [Vec<Field>; JobKind::ALL.len()],
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
        /// The box, 0 to 3.
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
    /// The mask of enabled lanes: no number.
    Mask,
    /// Whether the beat is its vector's last: no number.
    Reset,
    /// A port of unknown meaning.
    Unknown,
}

impl Layout {
    /// The layout of a model's jobs.
    pub fn of(model: &WordModel) -> Self {
        let inputs = |kind: JobKind| model.kind(kind.name()).map_or(&[][..], |kind| model.inputs(kind));
        let fields = |kind| inputs(kind).iter().map(|port| Field::of(&port.name)).collect();
        Self { fields: JobKind::ALL.map(fields) }
    }

    /// The fields of an operation's jobs.
    pub fn fields(&self, kind: JobKind) -> &[Field] {
        &self.fields[kind as usize]
    }
}

impl Field {
    /// Whether the word is a number.
    pub fn is_number(self) -> bool {
        !matches!(self, Self::Axis(_) | Self::Mask | Self::Reset | Self::Unknown)
    }

    /// The field of a port, by the port's name.
    fn of(port: &str) -> Self {
        let one_of = |names: &str, name: &str| names.split(' ').position(|known| known == name);
        let axis = |name: &str| one_of("x y z", name);
        let parts: Vec<&str> = port.split('_').collect();
        let field = match parts.as_slice() {
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

#[cfg(test)]
mod tests {
    use super::*;
    use raypath_rtl::Config;
    use raypath_sim::Datapath;

    #[test]
    fn every_port_is_known_and_distinct() {
        let layout = Layout::of(&Datapath::paper(Config::DEFAULT).model());
        for kind in JobKind::ALL {
            let fields = layout.fields(kind);
            assert!(!fields.contains(&Field::Unknown), "{kind}: {fields:?}");
            assert!((1..fields.len()).all(|i| !fields[..i].contains(&fields[i])), "{kind}: {fields:?}");
        }
    }
}
