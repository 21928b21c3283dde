//! A traversal without time: its jobs run at once, with the same hit and counts.

use super::{Request, StackEntry, State, Traversal};
use crate::Goal;
use raypath_model::{OneRay, SimdKernels};
use raypath_ops::{
    Binary32, Operation, RayBox, RayBoxInput, RayTriangle, RayTriangleInput, Rounding, Rules, Triangle, Vec3, array_of,
};
use raypath_scene::bvh::Target;

impl Traversal<'_> {
    /// Runs a traversal that was started to its end.
    #[inline]
    pub(in crate::trace) fn run(&mut self) {
        // A copy for each, in which the rules are constants.
        match (OneRay::new(&self.ray), self.tracing.rules) {
            (Some(ray), Rules::Paper) => self.run_in_lanes(ray, Rules::Paper),
            (Some(ray), Rules::Bounds(bits)) => self.run_in_lanes(ray, Rules::Bounds(bits)),
            // Without SIMD instructions, and with the rules of the original.
            (_, rules) => self.run_job_by_job(rules),
        }
    }

    fn run_job_by_job(&mut self, rules: Rules) {
        loop {
            match self.next_request() {
                Request::Fetch => {}
                Request::Boxes(boxes) => {
                    let input = RayBoxInput { ray: self.ray, aabb: *boxes };
                    let (output, ()) =
                        RayBox { rules, is_conservative: true }.run_with(Binary32, SimdKernels, input, ());
                    self.finish_boxes(&output);
                }
                Request::Triangle(triangle) => {
                    let input = RayTriangleInput { ray: self.ray, triangle };
                    let op = RayTriangle { rules, rounding: Rounding::Unit };
                    let (output, ()) = op.run_with(Binary32, SimdKernels, input, ());
                    self.finish_triangle(&output);
                }
                // No job is outstanding, so the traversal does not wait.
                Request::Wait | Request::Done => return,
            }
        }
    }

    #[inline(always)]
    fn run_in_lanes(&mut self, mut ray: OneRay, rules: Rules) {
        let bvh = self.bvh;
        self.state = State::Done;
        while let Some(StackEntry { reference, tmin }) = self.stack.pop() {
            let is_near = tmin <= f32::from(self.ray.extent);
            match reference.target() {
                _ if !is_near => {}
                Target::Node(node) => {
                    self.counts.nodes += 1;
                    self.counts.quadbox += 1;
                    let node = &bvh.nodes()[node as usize];
                    let found = ray.boxes(rules, array_of!(i => &node.boxes[i])).nearest_first();
                    for rank in (0..found.count as usize).rev() {
                        let reference = node.children[found.index[rank] as usize & 3];
                        self.stack.push(StackEntry { reference, tmin: found.tmin[rank] });
                    }
                }
                Target::Leaf { first, count } => {
                    self.counts.leaves += 1;
                    self.leaf(&mut ray, rules, first, count);
                    if self.goal == Goal::Any && self.best.is_some() {
                        return;
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn leaf(&mut self, ray: &mut OneRay, rules: Rules, first: u32, count: u32) {
        let op = RayTriangle { rules, rounding: Rounding::Unit };
        let two_sided = self.tracing.two_sided;
        self.counts.triangle += u64::from(count);
        self.counts.behind += if two_sided { u64::from(count) } else { 0 };
        for four in (0..count).step_by(4) {
            let in_four = (count - four).min(4);
            let slot = |i: usize| first + four + (i as u32).min(in_four - 1);
            let vertices: [[f32; 9]; 4] = array_of!(i => {
                let Triangle { a, b, c } = self.bvh.triangle(slot(i));
                let vertex = |v: &Vec3<Binary32>| [v.x.into(), v.y.into(), v.z.into()];
                let ([a, b, c], [d, e, f], [g, h, i]) = (vertex(a), vertex(b), vertex(c));
                [a, b, c, d, e, f, g, h, i]
            });
            let front = ray.fronts(op, |i, k| vertices[i][k]);
            // Only a face that is turned away can be hit from behind: its edges, and with them the denominator, are
            // negative. Of a triangle behind, b and c are exchanged.
            let may_hit = two_sided && front.t_denom[..in_four as usize].iter().any(|denominator| *denominator < 0.0);
            let behind = may_hit.then(|| ray.fronts(op, |i, k| vertices[i][[0, 1, 2, 6, 7, 8, 3, 4, 5][k]]));
            let sides = [Some(front), behind];
            for i in 0..in_four as usize {
                for (side, found) in (0..).zip(&sides) {
                    if let Some(found) = found.as_ref().filter(|found| found.hits >> i & 1 == 1) {
                        self.record_hit(2 * u64::from(slot(i)) + side, found.t_num[i], found.t_denom[i]);
                    }
                }
            }
        }
        ray.set_extent(self.ray.extent.into());
    }
}
