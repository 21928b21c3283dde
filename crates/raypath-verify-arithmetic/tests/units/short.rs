//! Units of formats with significands of 3 bits, which `symfpu` refuses: all pairs, against the software.

use raypath_float::Format;
use raypath_verify_arithmetic::units::bench::{Bench, UnitResults, Units};
use std::cmp::Ordering;

#[test]
fn significands_of_three_bits() {
    for exponent in [3, 4, 5] {
        let format = Format::new(exponent, 3).expect("a format");
        let mut bench = Units::new(format).and_then(|units| Bench::new(&units)).expect("a bench");
        let codes = 0..1_u64 << format.ieee_width();
        for (a, b) in codes.clone().flat_map(|a| codes.clone().map(move |b| (a, b))) {
            let order = format.compare(a, b);
            let expected = UnitResults {
                sum: format.add(a, b),
                difference: format.sub(a, b),
                product: format.mul(a, b),
                quotient: format.div(a, b),
                root: format.sqrt(a),
                less: order == Some(Ordering::Less),
                equal: order == Some(Ordering::Equal),
                unordered: order.is_none(),
            };
            assert_eq!(bench.run(a, b), expected, "{format}: {a:#x} and {b:#x}");
        }
    }
}
