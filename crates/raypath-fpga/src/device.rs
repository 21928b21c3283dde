//! The FPGAs that the flow supports.

/// An FPGA of Lattice's family ECP5, in the package CABGA381, or a family of Xilinx's, for synthesis only.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Device {
    /// LFE5U-25F: 24 k LUTs, 28 multipliers.
    Ecp5_25k,
    /// LFE5U-45F: 44 k LUTs, 72 multipliers.
    Ecp5_45k,
    /// LFE5U-85F: 84 k LUTs, 156 multipliers.
    Ecp5_85k,
    /// Series 7.
    Xilinx7,
    /// UltraScale+.
    XilinxUltrascalePlus,
}

raypath_ops::names! {
    Device {
        Ecp5_25k = "ecp5-25k", Ecp5_45k = "ecp5-45k", Ecp5_85k = "ecp5-85k",
        Xilinx7 = "xilinx-7", XilinxUltrascalePlus = "xilinx-ultrascale-plus"
    },
    /// A text that names no device.
    ParseDeviceError, "'{0}' is not a valid device, expected ecp5-25k, ecp5-45k, ecp5-85k, xilinx-7 or xilinx-ultrascale-plus"
}

/// What to place and route for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// The FPGA.
    pub device: Device,
    /// Its speed grade, 6 (the slowest) to 8.
    pub speed: u8,
    /// The clock that placement and routing aim at, in MHz; not a limit.
    pub clock_mhz: f64,
    /// The seed of the placement.
    pub seed: u32,
}

impl Device {
    /// Every device.
    pub const ALL: [Self; 5] =
        [Self::Ecp5_25k, Self::Ecp5_45k, Self::Ecp5_85k, Self::Xilinx7, Self::XilinxUltrascalePlus];

    /// Whether it is a family of Xilinx's, for which there is synthesis, but neither placement nor a clock.
    pub fn is_xilinx(self) -> bool {
        matches!(self, Self::Xilinx7 | Self::XilinxUltrascalePlus)
    }

    /// Its size as nextpnr writes it, or its family as Yosys does.
    pub(crate) fn of_tools(self) -> &'static str {
        ["25k", "45k", "85k", "xc7", "xcup"][self as usize]
    }

    /// The number of its multipliers of 18 by 18 bits, if it is one device.
    pub(crate) fn multipliers(self) -> Option<u64> {
        [28, 72, 156].get(self as usize).copied()
    }
}

impl Target {
    /// A device of the slowest grade, with 70 MHz as the aim and the seed 1.
    pub fn of(device: Device) -> Self {
        Self { device, speed: 6, clock_mhz: 70.0, seed: 1 }
    }

    /// The arguments for nextpnr that select it.
    pub(crate) fn arguments(self) -> Vec<String> {
        let Self { device, speed, clock_mhz, seed } = self;
        let size = format!("--{}", device.of_tools());
        let numbers = [("--speed", speed.to_string()), ("--freq", clock_mhz.to_string()), ("--seed", seed.to_string())];
        let numbers = numbers.into_iter().flat_map(|(option, value)| [option.to_string(), value]);
        [size, "--package".to_string(), "CABGA381".to_string()].into_iter().chain(numbers).collect()
    }
}
