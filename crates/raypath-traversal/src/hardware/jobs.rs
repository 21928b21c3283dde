//! The inputs of the datapath's operations.

use super::connect::{Named, Outputs};
use crate::blocks::BOX_WORDS;
use crate::instance::TransformInput;
use raypath_hdl::{Builder, Module};
use raypath_ops::{Binary32, RayBoxInput, RayTriangleInput, ports_of};

/// The parts from which the inputs of jobs come.
pub struct Jobs<'m> {
    pub rays: Outputs<'m>,
    pub blocks: Outputs<'m>,
    pub issue: Outputs<'m>,
    pub decoder: Option<Outputs<'m>>,
    /// What is kept of the fetch.
    pub fetched: Named<'m>,
}

impl<'m> Jobs<'m> {
    /// What offers the jobs.
    pub fn of_block(&self) -> &Outputs<'m> {
        self.decoder.as_ref().unwrap_or(&self.issue)
    }

    /// The inputs of the datapath's operations.
    pub fn inputs(&self, m: &'m Builder, datapath: &Module) -> Named<'m> {
        let mut found: Named<'m> = Vec::new();
        let mut corners = 0..;
        let mut vertices = 0..;
        let mut matrix = 0..;
        let boxes = ports_of::<RayBoxInput<Binary32>>().into_iter();
        let triangles = ports_of::<RayTriangleInput<Binary32>>().into_iter();
        let has_instances = datapath.inputs().iter().any(|port| port.name.starts_with("matrix_"));
        let transform = ports_of::<TransformInput<Binary32>>().into_iter().filter(|_| has_instances);
        for port in boxes.chain(triangles).chain(transform) {
            let name = port.name;
            if found.iter().any(|(known, _)| *known == name) || datapath.port_width(&format!("{name}_i")).is_none() {
                continue;
            }
            let wire = match name.strip_prefix("ray_") {
                Some("extent") => self.fetched[1].1,
                // The rules of the unit do not read the direction.
                Some(field) if field.starts_with("dir_") => m.constant(32, 0),
                Some(field) => self.rays.port(&format!("job_{field}")),
                None if name.starts_with("aabb_") => {
                    let corner: usize = corners.next().unwrap_or_default();
                    let word = box_word(corner);
                    self.decoder.as_ref().map_or_else(
                        || self.blocks.port(&format!("word_{word}")),
                        |decoder| decoder.port(&format!("bound_{word}")),
                    )
                }
                None if name.starts_with("point_") => {
                    let axis = name.trim_start_matches("point_");
                    let [origin, dir] = ["origin", "dir"].map(|of| self.rays.port(&format!("job_{of}_{axis}")));
                    self.of_block().port("is_last").mux(dir, origin)
                }
                None if name.starts_with("matrix_") => {
                    let place: usize = matrix.next().unwrap_or_default();
                    let words = self.decoder.as_ref().unwrap_or(&self.blocks);
                    let word = words.port(&format!("word_{place}"));
                    // A direction is not moved.
                    let is_moved = !self.of_block().port("is_last");
                    if name.ends_with("_t") { word & is_moved.replicate(32) } else { word }
                }
                None => {
                    let vertex: usize = vertices.next().unwrap_or_default();
                    match &self.decoder {
                        None => self.issue.port(&format!("triangle_{vertex}")),
                        Some(decoder) => decoder.port(&format!("word_{vertex}")),
                    }
                }
            };
            found.push((name, wire));
        }
        found
    }
}

/// The place in memory of a bound of the boxes of a block. In the operation's input, the bounds of a slab follow each
/// other; in memory the minima come first.
pub fn box_word(place: usize) -> usize {
    let (child, bound) = (place / BOX_WORDS, place % BOX_WORDS);
    let (axis, is_max) = (bound / 2, bound % 2);
    BOX_WORDS * child + 3 * is_max + axis
}
