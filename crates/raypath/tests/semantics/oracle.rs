//! The exact oracle, for the paper's operations in their own types.

use raypath::model::{WordModel, Words};
use raypath::ops::{Binary32, Job, Outcome, RayTriangleInput};
use raypath::oracle::exact;
use raypath::rtl::Config;
use raypath::sim::Datapath;
use std::cell::RefCell;

/// The oracle of a configuration, with its accumulators.
pub struct Oracle {
    exact: exact::Oracle,
    model: WordModel,
}

impl Default for Oracle {
    fn default() -> Self {
        Self::of(Config::DEFAULT)
    }
}

impl Oracle {
    fn of(config: Config) -> Self {
        let model = Datapath::paper(config).model();
        Self { exact: exact::Oracle::new(config.semantics, &model), model }
    }

    pub fn run(&mut self, job: &Job) -> Outcome {
        self.words(job).paper_outcome().expect("an operation of the paper")
    }

    fn words(&mut self, job: &Job) -> Words {
        self.exact.run(&self.model.paper_job(job).expect("a job")).expect("an outcome")
    }
}

/// The intermediate values of the triangle operation that the hit rules read.
#[derive(Debug, Clone, Copy)]
pub struct TriangleSteps {
    pub u: f32,
    pub v: f32,
    pub w: f32,
    pub t_num: f32,
    pub t_denom: f32,
}

impl TriangleSteps {
    pub fn of(input: &RayTriangleInput<Binary32>) -> Self {
        thread_local!(static ORACLE: RefCell<Oracle> = RefCell::new(Oracle::of(Config::DEFAULT.barycentrics(true))));
        let outcome = ORACLE.with_borrow_mut(|oracle| oracle.words(&Job::Triangle(*input)));
        let number = |port| f32::from_bits(outcome.port(port) as u32);
        let [u, v, w] = ["barycentric_u", "barycentric_v", "barycentric_w"].map(number);
        Self { u, v, w, t_num: number("t_num"), t_denom: number("t_denom") }
    }

    /// The hit by rule 6.
    pub fn hit_by_paper(self) -> bool {
        let Self { u, v, w, t_num, t_denom } = self;
        let any_nan = [u, v, w, t_num, t_denom].iter().any(|x| x.is_nan());
        !any_nan && u >= 0.0 && v >= 0.0 && w >= 0.0 && t_denom != 0.0 && t_num > 0.0
    }

    /// The hit by rule 6 of `chisel`.
    pub fn hit_by_chisel(self) -> bool {
        let Self { u, v, w, t_num, t_denom } = self;
        !(u < 0.0 || v < 0.0 || w < 0.0 || t_num < 0.0) && t_denom != 0.0
    }
}
