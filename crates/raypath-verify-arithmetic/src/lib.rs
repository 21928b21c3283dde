//! Verification of the floating-point units.

mod gates;
pub mod units;

use raypath_float::Format;
use raypath_verify::Item;
use units::bench::Units;
use units::proofs;

/// The claims about floating-point units.
pub const ITEMS: &[Item] = &[
    Item {
        name: "testfloat",
        claim: "the units add, subtract, multiply, divide, take roots and compare in binary32 as IEEE 754 specifies",
        oracle: "Berkeley SoftFloat, on the cases of Berkeley TestFloat and on hard ones",
        has_configuration: false,
        run: |request| units::testfloat(&Units::new(Format::BINARY32)?, request),
    },
    Item {
        name: "unit-proofs",
        claim: "adders (in binary32 by 55 cases, with exceptions), multipliers, dividers, square roots, comparison and \
            conversions give IEEE 754's result in its canonical word, for all operands; split and iterative units give \
            the words of the others; products and numbers with short significands are rounded in their direction; \
            sums of several terms round once",
        oracle: "Yosys's symfpu, the table of docs/reference/formats.md, and a definition of sums on integers, by SAT \
            (ABC)",
        has_configuration: false,
        run: proofs::unit_proofs,
    },
    Item {
        name: "multiplication",
        claim: "the multipliers of binary32 and of other formats, built of gates and with `*`, and by short factors, \
            give IEEE 754's product in its canonical word, and its exceptions, for all operands",
        oracle: "lemmas about the emitted signals, each proved by SAT (ABC), with Yosys's symfpu and a free product in \
            the last one; the theorem of docs/development/verification.md composes them",
        has_configuration: false,
        run: proofs::multiplication,
    },
    Item {
        name: "gates",
        claim: "the gates that `raypath ppa` synthesises for the floating-point units compute what their text says",
        oracle: "the emitted SystemVerilog, by SAT (ABC)",
        has_configuration: false,
        run: gates::gates,
    },
];
