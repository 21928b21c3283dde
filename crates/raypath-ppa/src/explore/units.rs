//! The areas of units, each synthesised once for all configurations, and what is known of a configuration.

use crate::attribution::cell_area;
use crate::{Bench, Design, Error, Report};
use raypath_tools::{Cache, Key, digest};
use raypath_work::pool::Progress;
use std::collections::BTreeMap;

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
        let areas = self.each(&units, &mut proceed, |(unit, (plan, place)), stop| {
            let area = cell_area(&self.netlist(plan, *place, &cache, stop)?, &self.library);
            cache.put(&self.unit_key(unit), &area)?;
            Ok((unit.clone(), area))
        })?;
        Ok(areas.into_iter().collect())
    }

    fn unit_key(&self, unit: &str) -> Key {
        let period = self.unit_period.unwrap_or(self.period);
        let (text, abc) = (period.to_string(), crate::recipe::abc(period));
        Key::new("unit-area", &[unit, &self.library.digest, &self.yosys.version, &text, &abc])
    }
}
