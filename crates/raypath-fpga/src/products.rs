//! The multipliers that the products of a design take.

use raypath_hdl::{Driver, Module};

/// A technology map for Yosys: products in three multipliers instead of four.
pub const MAP: &str = include_str!("products.v");

/// The module in place of which an ECP5 has a primitive.
pub const MULTIPLIER: &str = "raypath_mul_18x18";

/// Its text for an ECP5.
pub const PRIMITIVE: &str = include_str!("raypath_mul_18x18.v");

/// The bits of an operand of a multiplier.
const MULTIPLIER_BITS: u32 = 18;

/// The multipliers that `synth_ecp5` uses for a module and its instances: one for each 18 by 18 bits of a product.
pub fn multipliers(module: &Module) -> u64 {
    let own = module.signals().iter().filter_map(|signal| match signal.driver {
        Driver::Mul(a, b) => Some(parts(module.signal(a).width) * parts(module.signal(b).width)),
        _ => None,
    });
    own.chain(module.instances().iter().map(|instance| multipliers(&instance.module))).sum()
}

fn parts(bits: u32) -> u64 {
    bits.div_ceil(MULTIPLIER_BITS).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use raypath_float::{Format, Product};
    use raypath_hdl::{Builder, verilog};
    use raypath_tools::{Yosys, temporary_folder, write};
    use std::fmt::Write as _;
    use std::sync::atomic::AtomicBool;

    /// The map against exact products: Yosys evaluates both operands' extremes and random operands.
    #[test]
    fn three_multipliers_and_gates_make_the_product() {
        let m = Builder::new("product");
        let [a, b] = ["a_i", "b_i"].map(|name| m.input(name, 24));
        m.output("product_o", a * b);
        let module = m.finish().expect("a module");
        let folder = temporary_folder().expect("a folder");
        let place = |name: &str| folder.path().join(name);
        write(&place("product.sv"), &verilog::text(&module).expect("text")).expect("a file");
        write(&place("products.v"), MAP).expect("a file");
        let mut script = "read_verilog -sv product.sv\nproc\nopt_expr\nwreduce\ntechmap -map products.v\nclean\n\
                          select -assert-count 3 t:$mul\n"
            .to_string();
        let extremes = [0, 1, 0x3_ffff, 0x4_0000, 0xfc_0000, 0xff_ffff];
        let mut pairs: Vec<[u64; 2]> = extremes.iter().flat_map(|&a| extremes.map(|b| [a, b])).collect();
        let mut state = 1_u64;
        pairs.extend((0..100).map(|_| {
            [(); 2].map(|()| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                state >> 40
            })
        }));
        for [a, b] in &pairs {
            let _ = writeln!(script, "tee -a values.txt eval -set a_i 24'd{a} -set b_i 24'd{b} -show product_o");
        }
        write(&place("script.ys"), &script).expect("a file");
        let yosys = Yosys::find(None).expect("Yosys");
        yosys.run(folder.path(), "script.ys", "product", &AtomicBool::new(false)).expect("values");
        let printed = std::fs::read_to_string(place("values.txt")).expect("values");
        let values = printed.lines().filter_map(|line| line.split_once("\\product_o = 48'"));
        let values: Vec<u64> =
            values.map(|(_, bits)| u64::from_str_radix(bits.trim_end_matches('.'), 2).expect("bits")).collect();
        assert_eq!(values, pairs.iter().map(|[a, b]| a * b).collect::<Vec<_>>());
    }

    /// The primitive with a model of it: Yosys merges the registers and the product of both, so nothing is left to
    /// prove.
    #[test]
    fn the_primitive_does_what_the_text_does() {
        let folder = temporary_folder().expect("a folder");
        let place = |name: &str| folder.path().join(name);
        let module = raypath_float::multiplier(MULTIPLIER_BITS, MULTIPLIER_BITS).expect("a module");
        assert_eq!(module.name(), MULTIPLIER);
        let text = verilog::text(&module).expect("text");
        write(&place("text.sv"), &text.replace(MULTIPLIER, "by_text")).expect("a file");
        for (name, model) in [("model.v", include_str!("../tests/data/MULT18X18D.v")), ("primitive.v", PRIMITIVE)] {
            write(&place(name), model).expect("a file");
        }
        let script = "read_verilog -sv text.sv model.v primitive.v\nhierarchy\nproc\nflatten\nopt_clean\n\
                      miter -equiv -flatten by_text raypath_mul_18x18 miter\nhierarchy -top miter\nopt\n\
                      setundef -init -zero\nopt -share_all\nsat -verify -prove trigger 0 miter\n";
        write(&place("script.ys"), script).expect("a file");
        let yosys = Yosys::find(None).expect("Yosys");
        yosys.run(folder.path(), "script.ys", "miter", &AtomicBool::new(false)).expect("equality");
    }

    #[test]
    fn a_product_of_24_bits_takes_four() {
        let unit = raypath_float::mul(Format::BINARY32, Product::Inferred, false).expect("a unit");
        assert_eq!(multipliers(&unit), 4);
        let m = Builder::new("two");
        let [a, b] = ["a_i", "b_i"].map(|name| m.input(name, 33));
        for name in ["u_first", "u_second"] {
            let product = m.instance(name, &unit, &[("a_i", a), ("b_i", b)])[0];
            m.output(&format!("{name}_o"), product);
        }
        let [c, d] = ["c_i", "d_i"].map(|name| m.input(name, 18));
        m.output("product_o", c * d);
        assert_eq!(multipliers(&m.finish().expect("a module")), 2 * 4 + 1);
    }
}
