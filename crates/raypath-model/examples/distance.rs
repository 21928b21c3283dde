//! A distance between vectors that are longer than the datapath is wide.

use raypath_model::Functional;
use raypath_ops::{Beat, EuclideanInput, Job, Outcome, Rules};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // ANCHOR: beats
    let (query, candidate) = ([1.0; 40], [3.0; 40]);
    let mut datapath = Functional::<16, 8>::new(Rules::Paper);
    for beat in Beat::of(&query, &candidate)? {
        if let Outcome::Euclidean(sum) = datapath.run(&Job::Euclidean(EuclideanInput { euclidean: beat })) {
            let is_last = bool::from(sum.euclidean_reset_accum);
            println!("sum {}, last beat: {is_last}", f32::from(sum.euclidean_accumulator));
        }
    }
    // ANCHOR_END: beats
    Ok(())
}
