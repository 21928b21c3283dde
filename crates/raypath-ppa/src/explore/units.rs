//! The areas of units, each synthesised once for all configurations, and what is known of a configuration.

use crate::bench::{all, unless_stopped};
use crate::{Bench, Design, Error, Report};
use raypath_tools::{Cache, Key, digest};
use raypath_work::pool::{self, Progress};
use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

impl Bench {
    /// The report of a design, if the cache has it.
    ///
    /// # Errors
    /// A module that cannot be printed; a library without a cell that the design needs.
    pub fn known(&self, design: &Design) -> Result<Option<Report>, Error> {
        Ok(Cache::new(&self.cache).get(&self.plan(design)?.key))
    }

    /// The area of a unit, by the digest of its text, if it has been synthesised by [`unit_areas`](Self::unit_areas).
    pub fn unit_area(&self, unit: &str) -> Option<f64> {
        Cache::new(&self.cache).get(&self.unit_key(unit))
    }

    /// Synthesises the units of designs, and returns their areas by the digests of their texts. `proceed` gets the
    /// number of finished syntheses.
    ///
    /// # Errors
    /// Those of [`Bench::measure`].
    pub fn unit_areas(
        &self,
        designs: &[Design],
        mut proceed: impl FnMut(Progress) -> bool,
    ) -> Result<BTreeMap<String, f64>, Error> {
        let cache = Cache::new(&self.cache);
        let plans = designs.iter().map(|design| self.plan(design)).collect::<Result<Vec<_>, _>>()?;
        let mut units = BTreeMap::new();
        for plan in &plans {
            for (place, (block, _)) in plan.blocks.iter().enumerate().filter(|(_, (block, _))| block.is_unit) {
                units.entry(digest(block.text.as_bytes())).or_insert((plan, place));
            }
        }
        let units: Vec<_> = units.into_iter().collect();
        let synthesise = |(unit, (plan, place)): &(String, (&crate::bench::Plan<'_>, usize)), stop: &AtomicBool| {
            unless_stopped(self.netlist(plan, *place, &cache, stop).and_then(|netlist| {
                let cells = netlist.cells.iter().filter_map(|instance| self.library.cell(&instance.cell));
                let area: f64 = cells.map(|cell| cell.area).sum();
                cache.put(&self.unit_key(unit), &area)?;
                Ok((unit.clone(), area))
            }))
        };
        Ok(all(pool::map(&units, self.jobs, &mut proceed, synthesise)?)?.into_iter().collect())
    }

    fn unit_key(&self, unit: &str) -> Key {
        let period = self.unit_period.unwrap_or(self.period);
        let (text, abc) = (period.to_string(), crate::recipe::abc(period));
        Key::new("unit-area", &[unit, &self.library.digest, &self.yosys.version, &text, &abc])
    }
}
