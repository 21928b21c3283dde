//! Words have the bits of the ports in their order, without names.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_ops::{Binary32, Job, JobKind, Outcome};

#[test]
fn words_are_the_ports_in_order() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut words = vec![7];
    for kind in JobKind::ALL {
        for _ in 0..50 {
            let job: Job = Job::from_ports(kind, |_| rng.random());
            job.words(&mut words);
            assert_eq!(words, job.ports().iter().map(|port| port.bits).collect::<Vec<_>>());
            let again: Job = Job::from_words_in(Binary32, kind, &words);
            assert_eq!(again.ports(), job.ports());

            let outcome: Outcome = Outcome::from_ports(kind, |_| rng.random());
            outcome.words(&mut words);
            assert_eq!(words, outcome.ports().iter().map(|port| port.bits).collect::<Vec<_>>());
            assert_eq!(Outcome::from_words_in(Binary32, kind, &words), outcome);
        }
        // Missing words are 0.
        assert_eq!(
            Job::<16, 8>::from_words_in(Binary32, kind, &[]).ports(),
            Job::<16, 8>::from_ports(kind, |_| 0).ports()
        );
    }
}
