//! A ray against four boxes, then against a triangle, in the functional model.

use raypath_model::Functional;
use raypath_ops::{Aabb, Job, Outcome, Ray, RayBoxInput, RayTriangleInput, Rules, Triangle};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // ANCHOR: boxes
    let ray = Ray::new([0.0, 0.0, -5.0], [0.0, 0.0, 1.0], f32::INFINITY)?;
    let near = Aabb::new([-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]);
    let far = Aabb::new([-1.0, -1.0, 7.0], [1.0, 1.0, 9.0]);
    let aside = Aabb::new([4.0, 4.0, 4.0], [5.0, 5.0, 5.0]);

    let mut datapath = Functional::<16, 8>::new(Rules::Paper);
    let job = Job::Quadbox(RayBoxInput { ray, aabb: [far, aside, near, aside] });
    if let Outcome::Quadbox(hits) = datapath.run(&job) {
        for place in 0..4 {
            if hits.is_intersect.to_array()[place] {
                let (index, tmin) = (hits.box_index[place], hits.tmin[place]);
                println!("box {} at {}", u32::from(index), f32::from(tmin));
            }
        }
    }
    // ANCHOR_END: boxes

    // ANCHOR: triangle
    let triangle = Triangle::new([-1.0, -1.0, 0.0], [0.0, 1.0, 0.0], [1.0, -1.0, 0.0]);
    let job = Job::Triangle(RayTriangleInput { ray, triangle });
    if let Outcome::Triangle(hit) = datapath.run(&job) {
        let distance = f32::from(hit.t_num) / f32::from(hit.t_denom);
        println!("triangle at {distance}: {}", bool::from(hit.triangle_hit));
    }
    // ANCHOR_END: triangle
    Ok(())
}
