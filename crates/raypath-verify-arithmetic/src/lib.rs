//! Verification of the floating-point units.

mod gates;
pub mod units;

use raypath_float::Format;
use raypath_verify::Item;
use units::Dividers;
use units::bench::Units;
use units::proofs;

/// The claims about floating-point units.
pub const ITEMS: &[Item] = &[
    Item {
        name: "testfloat",
        claim: "the units add, subtract, multiply and compare binary32 as IEEE 754 specifies, unsplit and split, and \
            raise its exceptions",
        oracle: "Berkeley SoftFloat, on the cases of Berkeley TestFloat",
        has_configuration: false,
        run: |request| units::testfloat(&Units::new(Format::BINARY32)?, &Units::with_flags(Format::BINARY32)?, request),
    },
    Item {
        name: "conversions",
        claim: "recoding loses no number of binary32, keeps their order and follows its table; every word of the \
            classes zero, infinity and NaN is decoded by its class alone",
        oracle: "the host's conversion to binary64, and the table of docs/reference/formats.md",
        has_configuration: false,
        run: |request| units::conversions(&Units::new(Format::BINARY32)?, request),
    },
    Item {
        name: "small-formats",
        claim: "the units of small formats give IEEE 754's result for every pair of operands, unsplit and split",
        oracle: "LLVM's soft float, in the crate rustc_apfloat",
        has_configuration: false,
        run: |request| units::small_formats(&|format| Ok(Units::new(format)?), request),
    },
    Item {
        name: "division",
        claim: "the units give IEEE 754's quotients, reciprocals and square roots, pipelined and iterative",
        oracle: "Berkeley SoftFloat in binary32, on the cases of Berkeley TestFloat and other numbers, and in \
            binary16; LLVM's soft float, in the crate rustc_apfloat, and the host's roots in small formats",
        has_configuration: false,
        run: |request| units::division(&Dividers::new, request),
    },
    Item {
        name: "unit-proofs",
        claim: "adders, multipliers, dividers, square roots, comparison and conversions give IEEE 754's result for all \
            operands; split and iterative units give the result of the unsplit ones; products and numbers with short \
            significands are rounded in their direction; sums of several terms round once",
        oracle: "Yosys's symfpu, and a definition of sums on integers, by SAT (ABC)",
        has_configuration: false,
        run: proofs::unit_proofs,
    },
    Item {
        name: "multiplication",
        claim: "the multipliers of binary32 and of other formats, built of gates and with `*`, and by short factors, \
            give IEEE 754's product for all operands, and its exceptions",
        oracle: "lemmas about the emitted signals, each proved by SAT (ABC), with Yosys's symfpu and a free product in \
            the last one; the theorem of docs/development/verification.md composes them",
        has_configuration: false,
        run: proofs::multiplication,
    },
    Item {
        name: "adder-proof",
        claim: "the binary32 adder gives IEEE 754's sum for all operands",
        oracle: "Yosys's symfpu, by SAT (ABC), in 55 cases of the difference of exponents",
        has_configuration: false,
        run: proofs::adder_proof,
    },
    Item {
        name: "gates",
        claim: "the gates that `raypath ppa` synthesises for the floating-point units compute what their text says",
        oracle: "the emitted SystemVerilog, by SAT (ABC)",
        has_configuration: false,
        run: gates::gates,
    },
];
