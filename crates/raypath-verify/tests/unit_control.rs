//! Proofs of the control of the traversal unit: what the item does not run at its least level.

use raypath_verify::unit::proofs::{Setting, check};
use raypath_verify::{Level, Shard};

#[test]
fn the_proofs_refute_every_fault() {
    let setting = Setting::least(false).expect("a unit");
    let obligations = setting.faults().expect("texts");
    assert!(obligations.len() > 40);
    let results = check(&obligations, Shard::ALL, &mut |_| true).expect("results");
    for (obligation, result) in obligations.iter().zip(results) {
        let (is_proof, failure) = result.expect("a result");
        assert!(!is_proof && failure.is_none(), "{}: {failure:?}", obligation.problem.name);
    }
}

#[test]
#[ignore = "prints the time of each proof"]
fn times() {
    let level = if std::env::var_os("FULL").is_some() { Level::Full } else { Level::Regression };
    for obligation in raypath_verify::unit::proofs::obligations(level).expect("obligations") {
        let begin = std::time::Instant::now();
        let result = check(std::slice::from_ref(&obligation), Shard::ALL, &mut |_| true).expect("a result");
        println!("{:6.1} s {} {result:?}", begin.elapsed().as_secs_f64(), obligation.problem.name);
    }
}

#[test]
#[ignore = "prints what the item does"]
fn item() {
    let begin = std::time::Instant::now();
    let mut last = 0;
    let mut proceed = |progress: raypath_verify::Progress| {
        if progress.done != last {
            last = progress.done;
            println!("{:.1} {progress:?}", begin.elapsed().as_secs_f64());
        }
        true
    };
    let mut request = raypath_verify::Request::new(&mut proceed);
    if std::env::var_os("FULL").is_some() {
        request.level = Level::Full;
    }
    let item = raypath_verify::ITEMS.iter().find(|item| item.name == "unit").expect("the item");
    println!("{:#?} {:?}", (item.run)(&mut request), begin.elapsed());
}
