//! scratch
use raypath::rtl::*;
fn main() {
    let mut config = Config::DEFAULT;
    let args: Vec<String> = std::env::args().collect();
    for pair in args[2..].chunks(2) {
        let v = &pair[1];
        match pair[0].as_str() {
            "lanes" => config.lanes = v.parse().unwrap(),
            "rules" => config.rules = v.parse().unwrap(),
            "io" => config.io = v.parse().unwrap(),
            "registers" => config.registers = v.parse().unwrap(),
            "control" => config.control = v.parse().unwrap(),
            "sharing" => config.sharing = v.parse().unwrap(),
            "latency" => config.unit_latency = v.parse().unwrap(),
            _ => panic!(),
        }
    }
    let d = Datapath::new(config).unwrap();
    let mut all = String::new();
    for m in raypath::hdl::verilog::modules(d.top()).unwrap() {
        all += &raypath::hdl::verilog::print_module(&m, &[]).unwrap();
        all += "\n";
    }
    std::fs::write(&args[1], all).unwrap();
    eprintln!("{config}: {} FF latency {}", d.top().register_bits(), d.latency());
}
