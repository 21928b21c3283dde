//! What runs the unit cycle by cycle: its ports, and the simulated netlist behind them.

use crate::hardware::UnitNetlist;
use crate::model::{Hit, RayRequest, Reply, instance_of};
use crate::state::status;
use raypath_hdl::{Error, InputPort, Module, OutputPort, Simulator};
use std::sync::Arc;

/// The inputs of the unit in a cycle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct UnitInputs<'b> {
    /// A ray that is offered, with its number.
    pub ray: Option<(u64, RayRequest)>,
    /// Whether a hit is taken.
    pub hit_ready: bool,
    /// Whether a request is taken.
    pub request_ready: bool,
    /// A beat of the memory.
    pub response: Option<Response<'b>>,
}

/// A beat of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Response<'b> {
    /// The tag of the request.
    pub tag: u32,
    /// The memory reports an error.
    pub is_error: bool,
    /// The bytes of the beat: an eighth of the memory's width.
    pub beat: &'b [u8],
}

/// The outputs of the unit in a cycle. They depend on the cycles before alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnitOutputs {
    /// Whether a ray is accepted.
    pub ray_ready: bool,
    /// The number of a ray that has ended, and its reply.
    pub hit: Option<(u64, Reply)>,
    /// A request to the memory.
    pub request: Option<BlockRequest>,
    /// Whether a beat is taken, which is so in every cycle.
    pub response_ready: bool,
}

/// A request to the memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BlockRequest {
    /// The address of the block.
    pub address: u32,
    /// The tag of the response.
    pub tag: u32,
}

/// What runs the unit cycle by cycle.
pub trait UnitEngine {
    /// The outputs in this cycle.
    fn outputs(&mut self) -> UnitOutputs;
    /// The clock edge that ends this cycle.
    fn cycle(&mut self, inputs: &UnitInputs<'_>);
    /// A cycle in which `rst_ni` is 0.
    fn reset(&mut self);
}

/// The simulated netlist of the unit. Inputs of channels that are not valid have arbitrary values.
pub struct NetlistEngine {
    simulator: Simulator,
    inputs: Vec<InputPort>,
    outputs: Vec<OutputPort>,
    widths: Vec<u32>,
    arbitrary: u64,
}

impl NetlistEngine {
    /// A unit after a reset.
    ///
    /// # Errors
    /// A netlist that cannot be compiled.
    pub fn new(unit: &UnitNetlist) -> Result<Self, Error> {
        Self::of_module(&unit.top)
    }

    /// A module with the ports of a unit, such as a unit with a fault, after a reset.
    ///
    /// # Errors
    /// A netlist that cannot be compiled.
    pub fn of_module(top: &Arc<Module>) -> Result<Self, Error> {
        Self::observing(top, |_| false)
    }

    /// As [`of_module`](Self::of_module), with signals that can be observed: those whose hierarchical name is `wanted`
    /// ([`Simulator::observing`]).
    ///
    /// # Errors
    /// A netlist that cannot be compiled.
    pub fn observing(top: &Arc<Module>, wanted: impl Fn(&str) -> bool) -> Result<Self, Error> {
        let simulator = Simulator::observing(top, wanted)?;
        let input = |port: &raypath_hdl::Port| simulator.input(&port.name);
        let inputs = top.inputs().iter().map(input).collect::<Result<_, _>>()?;
        let output = |port: &raypath_hdl::Port| simulator.output(&port.name);
        let outputs = top.outputs().iter().map(output).collect::<Result<_, _>>()?;
        let widths = top.inputs().iter().map(|port| top.signal(port.signal).width).collect();
        Ok(Self { simulator, inputs, outputs, widths, arbitrary: 1 })
    }

    /// The simulator, from which observed signals are read.
    pub fn simulator(&self) -> &Simulator {
        &self.simulator
    }

    /// The state after a reset, with random values in registers without a reset value and in memories, on which nothing
    /// may depend. They, and the values of inputs that are not valid, follow from the seed.
    pub fn restart_randomly(&mut self, seed: u64) {
        self.simulator.restart_randomly(seed);
        self.arbitrary = seed | 1;
    }
}

impl UnitEngine for NetlistEngine {
    fn outputs(&mut self) -> UnitOutputs {
        self.simulator.settle();
        let words: Vec<u64> = self.outputs.iter().map(|&port| self.simulator.get(port)).collect();
        outputs_of(&words)
    }

    fn cycle(&mut self, inputs: &UnitInputs<'_>) {
        let arbitrary = &mut self.arbitrary;
        let words = words_of(inputs, &self.widths, || {
            *arbitrary = arbitrary.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            *arbitrary >> 8 ^ *arbitrary << 30
        });
        self.inputs.iter().zip(words).for_each(|(&port, word)| self.simulator.set(port, word));
        self.simulator.cycle();
    }

    fn reset(&mut self) {
        self.simulator.set_reset(true);
        self.simulator.cycle();
        self.simulator.set_reset(false);
    }
}

/// The words of the inputs of `raypath_unit`, in order, whose widths are given. Inputs of channels that are not valid
/// have the values of `arbitrary`.
pub fn words_of(inputs: &UnitInputs<'_>, widths: &[u32], mut arbitrary: impl FnMut() -> u64) -> Vec<u64> {
    let mut words: Vec<u64> = Vec::with_capacity(widths.len());
    words.push(inputs.ray.is_some().into());
    match inputs.ray {
        Some((id, ray)) => {
            let cull = u64::from(ray.cull_back) | u64::from(ray.cull_front) << 1;
            words.extend([id, ray.any_hit.into(), cull, ray.root.into()]);
            let numbers = ray.origin.into_iter().chain(ray.direction).chain([ray.t_min, ray.t_max]);
            words.extend(numbers.map(|number| u64::from(number.to_bits())));
        }
        None => words.extend((0..RAY_PORTS).map(|_| arbitrary())),
    }
    words.extend([inputs.hit_ready, inputs.request_ready, inputs.response.is_some()].map(u64::from));
    match inputs.response {
        Some(Response { tag, is_error, beat }) => {
            words.extend([u64::from(tag), is_error.into()]);
            words.extend(beat.as_chunks().0.iter().map(|bytes| u64::from(u32::from_le_bytes(*bytes))));
        }
        None => words.extend((words.len()..widths.len()).map(|_| arbitrary())),
    }
    words.iter_mut().zip(widths).for_each(|(word, width)| *word &= u64::MAX >> (64 - width));
    words
}

/// The ports of a ray besides `ray_valid_i`.
const RAY_PORTS: usize = 12;

/// The outputs of `raypath_unit` from their words, in order.
///
/// # Panics
/// Never for the words of all outputs.
pub fn outputs_of(words: &[u64]) -> UnitOutputs {
    let Some((&[ray_ready, has_hit, id, status, t, triangle, t_num, t_denom, back_face, nodes, triangles], rest)) =
        words.split_first_chunk()
    else {
        unreachable!("fewer outputs than the unit has")
    };
    let Some((features, &[has_request, address, tag, response_ready])) = rest.split_last_chunk() else {
        unreachable!("as above")
    };
    let (weights, instance) = match features.split_first_chunk() {
        Some((weights, instance)) => (Some(weights), instance),
        None => (None, features),
    };
    let number = |word: u64| f32::from_bits(word as u32);
    let hit = (status == u64::from(status::HIT)).then(|| Hit {
        triangle: triangle as u32,
        t: number(t),
        t_num: number(t_num),
        t_denom: number(t_denom),
        back_face: back_face == 1,
        barycentric: weights.map(|&[u, v]| [number(u), number(v)]),
        instance: instance.first().and_then(|&index| instance_of(index as u32)),
    });
    let reply = Reply { status: status as u32, hit, nodes: nodes as u32, triangles: triangles as u32 };
    UnitOutputs {
        ray_ready: ray_ready == 1,
        hit: (has_hit == 1).then_some((id, reply)),
        request: (has_request == 1).then_some(BlockRequest { address: address as u32, tag: tag as u32 }),
        response_ready: response_ready == 1,
    }
}
