//! What is known of configurations without synthesis: counts of the netlist, latency, and visits in scenes.

use super::space::Space;
use crate::commands::full::ppa::design;
use crate::commands::full::visits::{scenes, visits};
use crate::{CliError, Progress};
use raypath_float::Format;
use raypath_ops::Rules;
use raypath_ppa::explore::Structure;
use raypath_rtl::{Config, DatapathNetlist};
use raypath_tools::{Cache, Key, MemoryLimit, digest, read};
use raypath_work::pool::{self, ALL_CORES};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Ambient-occlusion rays per hit of the pictures in which visits are counted, as of `box-bits`.
const AMBIENT_OCCLUSION: u32 = 2;

/// What is cached depends on the program: on its elaboration and its traversal.
pub struct ExactCache {
    cache: Cache,
    program: String,
}

/// A configuration without synthesis.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Elaborated {
    pub structure: Structure,
    /// Cycles.
    pub latency: u32,
}

impl ExactCache {
    pub fn new(folder: &std::path::Path) -> Result<Self, CliError> {
        let program = std::env::current_exe()?;
        Ok(Self { cache: Cache::new(folder), program: digest(&read(&program)?) })
    }

    /// Elaborates the configurations of a space. One that cannot be elaborated is refused.
    pub fn elaborate(&self, space: &mut Space) -> Result<Vec<Elaborated>, CliError> {
        let mut progress = Progress::new("configurations elaborated", space.members.len());
        let mut reached = 0;
        let elaborate = |(_, config): &(String, Config), _: &std::sync::atomic::AtomicBool| {
            let key = Key::new("structure", &[&self.program, &config.to_string()]);
            if let Some(known) = self.cache.get::<Elaborated>(&key) {
                return Ok::<_, CliError>(Some(Ok(known)));
            }
            let elaborated = match DatapathNetlist::new(*config) {
                Ok(datapath) => {
                    let structure = Structure::of(&design(*config)?)?;
                    Elaborated { structure, latency: datapath.latency() }
                }
                Err(reason) => return Ok(Some(Err(reason.to_string()))),
            };
            self.cache.put(&key, &elaborated)?;
            Ok(Some(Ok(elaborated)))
        };
        let mut watch = |steps: pool::Progress| {
            reached = steps.done as usize;
            progress.at(reached)
        };
        let found = pool::map(&space.members, ALL_CORES, &mut watch, elaborate)?;
        progress.finish(reached)?;
        let mut kept = Vec::new();
        let mut members = Vec::new();
        for (member, found) in std::mem::take(&mut space.members).into_iter().zip(found.into_iter().flatten()) {
            match found {
                Ok(elaborated) => {
                    members.push(member);
                    kept.push(elaborated);
                }
                Err(reason) => *space.refused.entry(reason).or_default() += 1,
            }
        }
        space.members = members;
        Ok(kept)
    }

    /// The visits that each configuration adds, in percent, in the scene where it adds most. None where they cannot be
    /// computed: in other formats than binary32.
    pub fn visits(
        &self,
        configs: &[Config],
        paths: &[PathBuf],
        limit: MemoryLimit,
    ) -> Result<Vec<Option<f64>>, CliError> {
        let is_known = |config: &Config| config.semantics.format == Format::BINARY32;
        let mut contents = vec![self.program.clone()];
        for path in paths {
            let refused = |problem| CliError::unusable(format!("{}: {problem}", path.display()));
            contents.push(digest(&limit.read(path).map_err(refused)?));
        }
        let rules: Vec<Option<Rules>> =
            configs.iter().map(|config| is_known(config).then(|| config.semantics.rules_in_full())).collect();
        let mut distinct = vec![Rules::Paper];
        for rules in rules.iter().flatten() {
            if !distinct.contains(rules) {
                distinct.push(*rules);
            }
        }
        let mut counts: BTreeMap<String, Vec<u64>> = BTreeMap::new();
        let mut progress = Progress::new("rules in pictures", distinct.len());
        let mut shown = None;
        for (done, rules) in distinct.iter().enumerate() {
            let name = format!("{rules:?}");
            let parts: Vec<&str> = contents.iter().chain([&name]).map(String::as_str).collect();
            let key = Key::new("visits", &parts);
            let count = || {
                let scenes = match &shown {
                    Some(scenes) => scenes,
                    None => shown.insert(scenes(paths, limit)?),
                };
                scenes.iter().map(|scene| visits(scene, *rules, AMBIENT_OCCLUSION)).collect::<Result<_, CliError>>()
            };
            counts.insert(name, self.cache.kept(&key, |_| true, count)?);
            if !progress.at(done + 1) {
                break;
            }
        }
        progress.finish(counts.len())?;
        let paper = counts.get(&format!("{:?}", Rules::Paper)).cloned().unwrap_or_default();
        let added = |rules: &Rules| {
            let own = counts.get(&format!("{rules:?}"))?;
            let percent = own.iter().zip(&paper).map(|(own, paper)| 100.0 * (*own as f64 / *paper as f64 - 1.0));
            percent.reduce(f64::max)
        };
        Ok(rules.iter().map(|rules| added(rules.as_ref()?)).collect())
    }
}
