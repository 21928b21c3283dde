//! Scenes in memory that are placed in another, in any number of levels.

use crate::blocks::{Blocks, BlocksError, Placed};
use crate::mesh::{Bounds, Mesh};
use crate::placement::Placement;
use crate::scene::SceneError;
use raypath_traversal::blocks::{Child, NodeKind, children, move_children};
use std::collections::HashMap;

/// A scene in memory that others are made of.
#[derive(Debug, Clone, Copy)]
pub struct Member<'s> {
    /// Its bytes, from address 0 on.
    pub bytes: &'s [u8],
    /// The child word of its root.
    pub root: u32,
    /// The box around it, with the margins of instances in it.
    pub bounds: Bounds,
    /// The reach for which it was built.
    pub reach: f32,
}

/// A scene of scenes.
#[derive(Debug, Clone)]
pub struct Group {
    /// Its blocks.
    pub blocks: Blocks,
    /// The box around it, with the margins of its instances.
    pub bounds: Bounds,
    /// Its reach.
    pub reach: f32,
}

/// A member at a place: its number.
pub type MemberPlace = (usize, Placement);

/// The scene of members at these places, for ray origins within `reach` as in
/// [`Scene::of_instances_with_reach`](crate::Scene::of_instances_with_reach); 16 times its longest side by default. The
/// index of an instance is its position here.
///
/// # Errors
/// No place; a scene that is too large or too deep; a place that is too far away; a member that is no scene of these
/// nodes or does not exist, or was built for a smaller reach than its places need.
pub fn group(
    members: &[Member<'_>],
    places: &[MemberPlace],
    reach: Option<f32>,
    nodes: NodeKind,
) -> Result<Group, SceneError> {
    let refused = |number: usize, problem: String| SceneError::Member { number, problem };
    if let Some(&(number, _)) = places.iter().find(|(number, _)| *number >= members.len()) {
        return Err(refused(number, format!("expected less than {}, the number of scenes", members.len())));
    }
    let own: Vec<(Placement, Bounds)> =
        places.iter().map(|&(member, placement)| (placement, members[member].bounds)).collect();
    let Margins { reach, pads, .. } = Margins::of(&own, reach)?;
    for &(member, placement) in places {
        let (built, needed) = (members[member].reach, placement.object_reach(reach));
        if built < needed {
            return Err(SceneError::Reach { member, built, needed });
        }
    }
    let (mut bytes, mut roots, mut has_instances) = (Vec::new(), Vec::new(), false);
    for (number, member) in members.iter().enumerate() {
        let offset = u32::try_from(bytes.len()).map_err(|_| BlocksError::TooLarge { bytes: bytes.len() as u64 })?;
        let (first, block) = (bytes.len(), nodes.block_bytes() as usize);
        if !member.bytes.len().is_multiple_of(block) {
            return Err(refused(number, format!("{} bytes, expected a multiple of {block}", member.bytes.len())));
        }
        bytes.extend(member.bytes);
        let mut moved =
            Moved { bytes: &mut bytes[first..], nodes, offset, levels: HashMap::new(), has_instances: false };
        let levels = moved.levels(member.root, 0).map_err(|problem| refused(number, problem))?;
        has_instances |= moved.has_instances;
        roots.push((moved.word(member.root), levels));
    }
    let placed: Vec<Placed> = places
        .iter()
        .zip(own.iter().zip(pads))
        .map(|(&(member, placement), ((_, own), pad))| Placed {
            placement,
            object: roots[member],
            bounds: placement.bounds(*own),
            pad,
        })
        .collect();
    let mut blocks = Blocks::of_bytes(bytes, nodes, 0, 0).placed(&placed)?;
    blocks.nest_if(has_instances);
    Ok(Group { bounds: blocks.bounds(), blocks, reach })
}

/// How much larger the boxes of instances must be.
pub(crate) struct Margins {
    /// The reach of the scene.
    pub reach: f32,
    /// The box around all.
    pub bounds: Bounds,
    /// For each instance.
    pub pads: Vec<f64>,
}

/// The default reach in units of the longest side of a scene of instances.
const DEFAULT_REACH: f32 = 16.0;

impl Margins {
    /// The margins of objects with these bounds at these places.
    ///
    /// # Errors
    /// No place, or one that is too far away.
    pub fn of(places: &[(Placement, Bounds)], reach: Option<f32>) -> Result<Self, SceneError> {
        if places.is_empty() {
            return Err(SceneError::Empty);
        }
        let bounds = places.iter().fold(Bounds::EMPTY, |all, (placement, own)| all.union(placement.bounds(*own)));
        let side = bounds.longest_side();
        let reach = reach.unwrap_or(DEFAULT_REACH * side).max(side);
        let coordinate = reach + bounds.min.iter().chain(&bounds.max).fold(0.0, |most: f32, x| most.max(x.abs()));
        // A coordinate that is not a number is far.
        let is_near = |length: f32| length <= Mesh::MAX_COORDINATE;
        let is_far =
            |(placement, _): &(Placement, Bounds)| !(is_near(placement.object_reach(reach)) && is_near(coordinate));
        if let Some(instance) = places.iter().position(is_far) {
            return Err(SceneError::Far(instance));
        }
        let pads = places.iter().map(|(placement, _)| placement.pad(reach, coordinate)).collect();
        Ok(Self { reach, bounds, pads })
    }
}

/// A member whose addresses are moved.
struct Moved<'s> {
    bytes: &'s mut [u8],
    nodes: NodeKind,
    offset: u32,
    /// The levels of nodes and instances below each block that has been moved.
    levels: HashMap<u32, u32>,
    has_instances: bool,
}

impl Moved<'_> {
    /// A child word after the move.
    fn word(&self, word: u32) -> u32 {
        if word == 0 { 0 } else { word.wrapping_add(self.offset) }
    }

    /// Moves what a child word refers to, once, and returns its levels.
    fn levels(&mut self, word: u32, above: u32) -> Result<u32, String> {
        let child = Child::of(word, self.nodes).map_err(|problem| problem.to_string())?;
        let address = match child {
            Child::Node { address } => address,
            Child::Instance { address } => {
                self.has_instances = true;
                address
            }
            Child::None | Child::Leaf { .. } | Child::Box { .. } => return Ok(0),
        };
        if let Some(levels) = self.levels.get(&address) {
            return Ok(*levels);
        }
        let bytes = self.bytes.len();
        let missing = || format!("a block at address {address:#x}, expected one of its {bytes} bytes");
        let block = address as usize..address as usize + self.nodes.block_bytes() as usize;
        let mut words = children(self.bytes.get(block.clone()).ok_or_else(missing)?, child, self.nodes);
        words.retain(|word| *word != 0);
        let own = if let Child::Node { .. } = child { self.nodes.node_levels(words.len()) } else { 1 };
        if above + own > raypath_traversal::LEVELS {
            return Err(BlocksError::TooDeep { levels: above + own }.to_string());
        }
        let mut below = 0;
        for word in words {
            below = below.max(self.levels(word, above + own)?);
        }
        move_children(&mut self.bytes[block], child, self.nodes, self.offset);
        let levels = own + below;
        self.levels.insert(address, levels);
        Ok(levels)
    }
}
