//! scratch
use raypath::check::{lockstep, timing};
use raypath::engine::*;
use raypath::jobs;
use raypath::model::Model;
use raypath::models::*;
use raypath::ops::Rules;
use raypath::rtl::*;
use raypath::traffic::Traffic;
struct V(Config);
impl Visitor for V {
    type Answer = usize;
    fn visit<M: Model>(self, model: M) -> usize {
        let config = self.0;
        let d = match Datapath::new(config) {
            Ok(d) => d,
            Err(e) => {
                println!("{config}: {e}");
                return 1;
            }
        };
        let mut n = NetlistEngine::of(model.clone(), config, &d, |_| false).unwrap();
        let job = jobs::random(&model, config.format, 1, config.kinds()).next().unwrap();
        let t = timing(&mut n, &job);
        let f = lockstep(
            &mut n,
            model.clone(),
            jobs::random(&model, config.format, 2, config.kinds()).take(3000),
            &mut Traffic::random(1),
            |_| true,
        );
        println!(
            "{config}: {} FF, {t:?} {} jobs {} different {}",
            d.top().register_bits(),
            f.jobs,
            f.different,
            f.differences.first().map_or("", |s| s)
        );
        f.different + (3000 - f.jobs)
    }
}
fn main() {
    let mut bad = 0;
    for &io in Encoding::ALL {
        for &registers in Encoding::ALL {
            for &lanes in Lanes::ALL {
                let config = Config { io, registers, lanes, ..Config::DEFAULT };
                bad += with_model(config, V(config));
            }
        }
    }
    for &control in Control::ALL {
        for &sharing in Sharing::ALL {
            for &unit_latency in UnitLatency::ALL {
                for lanes in [Lanes::None, Lanes::Two, Lanes::Sixteen, Lanes::SixtyFour] {
                    for rules in [Rules::Paper, Rules::Chisel] {
                        let config = Config { control, sharing, unit_latency, lanes, rules, ..Config::DEFAULT };
                        bad += with_model(config, V(config));
                    }
                }
            }
        }
    }
    for f in ["e8s11", "e8s8", "e5s11", "e3s3", "e11s24", "e4s4"] {
        let (e, s) = f[1..].split_once('s').unwrap();
        let format = raypath::float::Format::new(e.parse().unwrap(), s.parse().unwrap()).unwrap();
        for &io in Encoding::ALL {
            for &registers in Encoding::ALL {
                for control in [Control::Skid, Control::Credit] {
                    let config = Config { io, registers, format, control, ..Config::DEFAULT };
                    bad += with_model(config, V(config));
                }
            }
        }
    }
    println!("bad {bad}");
}
