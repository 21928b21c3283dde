//! Pictures and hits whose rows and rays several machines divide.

use crate::CliError;
use crate::commands::full::division::{Division, DivisionArguments};
use crate::commands::full::watched;
use raypath_ops::{Binary32, Ray};
use raypath_render::{
    Camera, Costs, Counts, Hit, Rendering, Rows, Scene, Shading, Tracing, render_rows, trace_closest,
};
use raypath_work::parts::Parts;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::time::Instant;

/// The name of the results in a part.
const TASK: &str = "render";

/// The rendering of the shard, or of what is merged.
pub struct Divided<'a> {
    arguments: &'a DivisionArguments,
    division: Division,
    parts: Parts,
    begin: Instant,
}

impl<'a> Divided<'a> {
    /// Begins; `work` names the scene and what to do with it.
    pub fn begin(arguments: &'a DivisionArguments, work: String) -> Result<Self, CliError> {
        let division = arguments.begin_whole(work)?;
        let parts = division.parts(TASK)?;
        Ok(Self { arguments, division, parts, begin: Instant::now() })
    }

    /// Renders the shard's rows, and joins what there is: for a part, the rendering is not the whole picture, and none.
    pub fn render(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        size: (u32, u32),
        shading: &Shading,
    ) -> Result<Option<Rendering>, CliError> {
        let rows = self.arguments.shard().range(size.1.into());
        let rows = rows.start as u32..rows.end as u32;
        let shards = self.parts.phase(|| {
            let pixels = rows.len() * size.0 as usize;
            let rendered =
                watched("pixels", pixels, |watch| render_rows(scene, camera, size, shading, rows.clone(), watch))?;
            Ok::<_, CliError>(SavedRows::from(rendered))
        })?;
        if self.parts.is_saved() {
            return Ok(None);
        }
        let rendering = Rendering::of(size, shards.into_iter().map(Rows::from));
        rendering.map(Some).map_err(CliError::unusable)
    }

    /// Traces the shard's rays, or takes the hits of all shards.
    pub fn trace(
        &mut self,
        scene: &Scene,
        rays: &[Ray<Binary32>],
        tracing: Tracing,
    ) -> Result<Vec<Option<Hit>>, CliError> {
        let Range { start, end } = self.arguments.shard().range(rays.len() as u64);
        let rays = &rays[start as usize..end as usize];
        let shards = self.parts.phase(|| {
            let (hits, _) = watched("rays", rays.len(), |watch| trace_closest(scene, rays, tracing, watch))?;
            Ok::<Vec<Option<SavedHit>>, CliError>(hits.into_iter().map(|hit| hit.map(saved)).collect())
        })?;
        Ok(shards.into_iter().flatten().map(|hit| hit.map(restored)).collect())
    }

    /// The seconds so far, or those that all shards took.
    pub fn seconds(&self) -> f64 {
        self.parts.seconds().unwrap_or(self.begin.elapsed().as_secs_f64())
    }

    /// Writes the part, if one is wanted, and returns its message.
    pub fn write(mut self) -> Result<Option<String>, CliError> {
        self.division.keep(TASK, self.parts, self.begin.elapsed().as_secs_f64());
        self.division.write()
    }
}

/// A hit: triangle, from behind, the bits of `t_num`, `t_denom` and `t`, and the instance.
type SavedHit = (u32, bool, [u32; 3], Option<u32>);

fn saved(hit: Hit) -> SavedHit {
    (hit.triangle, hit.from_behind, [hit.t_num, hit.t_denom, hit.t].map(f32::to_bits), hit.instance)
}

fn restored((triangle, from_behind, bits, instance): SavedHit) -> Hit {
    let [t_num, t_denom, t] = bits.map(f32::from_bits);
    Hit { triangle, from_behind, t_num, t_denom, t, instance }
}

#[derive(Serialize, Deserialize)]
struct SavedRows {
    colours: Vec<[u8; 3]>,
    jobs: Vec<u32>,
    /// For each kind of ray: rays, hits, quadbox and triangle jobs, jobs from behind, nodes, leaves.
    costs: [[u64; 7]; 3],
}

impl From<Rows> for SavedRows {
    fn from(Rows { colours, jobs, costs }: Rows) -> Self {
        let costs = costs.map(|Costs { rays, hits, counts }| {
            let Counts { quadbox, triangle, behind, nodes, leaves, .. } = counts;
            [rays, hits, quadbox, triangle, behind, nodes, leaves]
        });
        Self { colours, jobs, costs }
    }
}

impl From<SavedRows> for Rows {
    fn from(SavedRows { colours, jobs, costs }: SavedRows) -> Self {
        let costs = costs.map(|[rays, hits, quadbox, triangle, behind, nodes, leaves]| Costs {
            rays,
            hits,
            counts: Counts { quadbox, triangle, behind, nodes, leaves, ..Counts::default() },
        });
        Self { colours, jobs, costs }
    }
}
