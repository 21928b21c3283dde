//! A distance of vectors with more dimensions than the datapath has lanes.

use raypath_model::Functional;
use raypath_ops::{Beat, BeatInput, Job, Outcome, Rules};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // ANCHOR: beats
    let (query, candidate) = ([1.0; 40], [3.0; 40]);
    let mut datapath = Functional::<16, 8>::new(Rules::Paper);
    for beat in Beat::of(&query, &candidate)? {
        let job = Job::Euclidean(BeatInput { euclidean: beat });
        if let Outcome::Euclidean(output) = datapath.run(&job) {
            let sum = f32::from(output.euclidean_accumulator);
            let is_last = bool::from(output.euclidean_reset_accum);
            println!("sum {sum}, last beat: {is_last}");
        }
    }
    // ANCHOR_END: beats
    Ok(())
}
