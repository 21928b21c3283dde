//! The hardware of searches against their functional model, beside rays, with memories and users that stall.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use raypath_ops::Rules;
use raypath_rtl::{Config, Control, Interval, UnitLatency};
use raypath_tools::Sources;
use raypath_traversal::blocks::NodeKind;
use raypath_traversal::search::{SearchImage, SearchStatus, Searches, search};
use raypath_traversal::traffic::{
    Behaviour, BlockScene, Environment, SearchBehaviour, SearchTraffic, random_ray, random_searches,
};
use raypath_traversal::{NetlistEngine, StepParameters, Unit, UnitFeatures, UnitModel, UnitNetlist, UnitParameters};

#[test]
fn the_hardware_returns_what_the_model_returns_beside_rays() {
    let fast = Config::DEFAULT.control(Control::Credit).unit_latency(UnitLatency { sums: 5, products: 4 });
    let folded = Config::DEFAULT.interval(Interval::Four);
    let more = "k=16,m=64,contexts=4,dimensions=128,blocks=32,remembered=64,turns=2,trees=1";
    let less = "k=12,m=65,contexts=3,dimensions=100,blocks=16,remembered=128,turns=1,trees=1";
    for (seed, config, text, memory_width, stalls, errors) in [
        (1, Config::DEFAULT, more, 512, 0, 100),
        (2, fast, less, 512, 80, 0),
        (3, Config::DEFAULT, less, 128, 60, 50),
        (4, folded, more, 256, 120, 0),
    ] {
        let searches: Searches = text.parse().expect("searches");
        let search_parameters = searches.0.expect("searches");
        let mut image = SearchImage::new();
        let jobs = random_searches(seed, 60, search_parameters, &mut image).expect("jobs");
        // Transforms of rays have an opcode beside those of searches.
        let features = UnitFeatures { instances: stalls == 0, ..UnitFeatures::default() };
        let step = StepParameters { features, ..StepParameters::default() };
        let parameters =
            UnitParameters { contexts: 8, memory_width, step, search: searches, ..UnitParameters::default() };
        let unit = UnitNetlist::new(config, parameters).expect("a unit");
        let mut engine = NetlistEngine::new(&unit).expect("an engine");
        engine.restart_randomly(seed);
        let mut model = UnitModel::of(&unit);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let (scene, root) = BlockScene::random_of(NodeKind::Wide4, 60, &mut random);
        let rays: Vec<_> = (0..100).map(|_| random_ray(root, &mut random)).collect();
        let behaviour = Behaviour { latency: (20, 60), stalls: [stalls; 4], errors: 0 };
        let mut environment = Environment::new(&scene.0, parameters, rays.clone(), behaviour, seed);
        let behaviour = SearchBehaviour { latency: (1, 60), stalls, errors, memory_width };
        environment.searches = Some(SearchTraffic::new(&image, jobs.clone(), behaviour, seed));
        for cycle in 0.. {
            let searches = environment.searches.as_ref().expect("searches");
            if environment.is_done() {
                break;
            }
            assert!(cycle < 1_000_000, "{} of {} jobs have ended", searches.replies.len(), jobs.len());
            let checked = environment.cycle(&mut [&mut engine, &mut model]);
            checked.unwrap_or_else(|problem| panic!("seed {seed}: {problem}"));
        }
        let searches = environment.searches.expect("searches");
        for (number, job) in jobs.iter().enumerate() {
            let expected = search(&image, 0, *job, &search_parameters);
            let (status, neighbours) = &searches.replies[&(number as u64)];
            if errors > 0 && *status == SearchStatus::Memory {
                continue;
            }
            assert_eq!(*status, expected.status, "job {number} of seed {seed}");
            assert_eq!(*neighbours, expected.neighbours, "job {number} of seed {seed}");
        }
        let mut functional = Unit::new(Rules::Paper, step);
        let replies = rays.iter().zip(environment.replies.values());
        assert!(replies.into_iter().all(|(ray, reply)| functional.trace(&scene.0[..], ray) == *reply));
    }
}

#[test]
fn the_text_of_a_unit_with_searches_has_no_report_of_the_linters() {
    for text in ["k=32,m=64", "k=1,m=9,contexts=3,dimensions=100,blocks=16,remembered=64,turns=3,trees=1"] {
        let search = text.parse().expect("searches");
        let parameters = UnitParameters { search, contexts: 16, memory_width: 256, ..UnitParameters::default() };
        let unit = UnitNetlist::new(Config::DEFAULT, parameters).expect("a unit");
        let folder = tempfile::tempdir().expect("a folder");
        let sources = Sources::write(&unit.emitted().expect("a text"), folder.path()).expect("sources");
        sources.lint().expect("no report of the linters");
    }
}
