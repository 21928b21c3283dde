use raypath::check::{lockstep, timing};
use raypath::engine::*;
use raypath::jobs;
use raypath::rtl::*;
use raypath::traffic::Traffic;
fn main() {
    for sharing in [Sharing::Union, Sharing::Segregated] {
        for registers in [Encoding::Recoded, Encoding::Ieee] {
            for lanes in [Lanes::None, Lanes::Sixteen] {
                for rules in [raypath::ops::Rules::Paper, raypath::ops::Rules::Chisel] {
                    let config = Config { sharing, registers, lanes, rules, ..Config::DEFAULT };
                    let d = Datapath::new(config).unwrap();
                    let mut n = NetlistEngine::of(&d, |_| false).unwrap();
                    let job = jobs::random(1, config.kinds()).next().unwrap();
                    let t = timing(&mut n, &job);
                    let f = lockstep(
                        &mut n,
                        rules,
                        jobs::random(1, config.kinds()).take(5000),
                        &mut Traffic::random(1),
                        |_| true,
                    );
                    println!(
                        "{config}: {} FF, {:?} {} jobs {} different",
                        d.top().register_bits(),
                        t,
                        f.jobs,
                        f.different
                    );
                }
            }
        }
    }
    // credit: outcomes only
    for sharing in [Sharing::Union, Sharing::Segregated] {
        let config = Config { control: Control::Credit, sharing, ..Config::DEFAULT };
        let d = Datapath::new(config).unwrap();
        let mut n = NetlistEngine::of(&d, |_| false).unwrap();
        let job = jobs::random(1, config.kinds()).next().unwrap();
        let t = timing(&mut n, &job);
        let jobs: Vec<_> = jobs::random(1, config.kinds()).take(5000).collect();
        let mut exp = Vec::new();
        evaluate(config.rules, jobs.iter(), |_, o| {
            exp.push(o);
            true
        });
        let mut bad = 0;
        let r = drive(&mut n, jobs.iter(), &mut Traffic::random(3), |i, o| {
            if o != exp[i] {
                bad += 1;
            }
            true
        });
        println!("{config}: {} FF {:?} {:?} bad {bad}", d.top().register_bits(), t, r);
    }
}
