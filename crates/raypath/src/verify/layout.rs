//! What each word of a job stands for.

use crate::models::PaperModel;
use raypath_model::OnPorts;
use raypath_ops::JobKind;

/// The fields of each kind of job, in the order of its words.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    fields: [Vec<Field>; JobKind::ALL.len()],
}

/// What a word stands for. Axes are 0 to 2.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Field {
    /// A coordinate of the ray's origin.
    Origin(usize),
    /// One of its direction.
    Direction(usize),
    /// One of its inverse direction.
    Inverse(usize),
    /// How far it reaches.
    Extent,
    /// Sx, Sy or Sz.
    Shear(usize),
    /// kx, ky or kz: no number.
    Axis(usize),
    /// A bound of a box.
    Bound {
        /// Which box, 0 to 3.
        place: usize,
        /// Along which axis.
        axis: usize,
        /// The greater one.
        is_max: bool,
    },
    /// A coordinate of a triangle's vertex.
    Vertex {
        /// Which vertex, 0 to 2.
        vertex: usize,
        /// Along which axis.
        axis: usize,
    },
    /// A coordinate of a vector.
    Lane {
        /// Of the candidate, not of the query.
        of_candidate: bool,
        /// Which lane.
        lane: usize,
    },
    /// Lanes that count: no number.
    Mask,
    /// The beat is its vector's last: no number.
    Reset,
    /// A port that verification knows nothing of.
    Unknown,
}

impl Layout {
    /// That of a model's jobs.
    pub fn of<M: PaperModel>(model: &M) -> Self {
        let fields = |kind| model.job(kind, |_| 0).ports().iter().map(|port| Field::of(&port.name)).collect();
        Self { fields: JobKind::ALL.map(fields) }
    }

    /// The fields of a kind of job.
    pub fn fields(&self, kind: JobKind) -> &[Field] {
        &self.fields[kind as usize]
    }
}

impl Field {
    /// Whether its bits are a number's.
    pub fn is_number(self) -> bool {
        !matches!(self, Self::Axis(_) | Self::Mask | Self::Reset | Self::Unknown)
    }

    /// The field behind a port.
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
            ["aabb", place, name, bound] => place.parse().ok().zip(axis(name)).map(|(place, axis)| {
                let is_max = *bound == "max";
                Self::Bound { place, axis, is_max }
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
    use raypath_model::Functional;
    use raypath_ops::Rules;

    #[test]
    fn every_port_is_known_and_distinct() {
        let layout = Layout::of(&Functional::<16, 8>::new(Rules::Paper));
        for kind in JobKind::ALL {
            let fields = layout.fields(kind);
            assert!(!fields.contains(&Field::Unknown), "{kind}: {fields:?}");
            assert!((1..fields.len()).all(|i| !fields[..i].contains(&fields[i])), "{kind}: {fields:?}");
        }
    }
}
