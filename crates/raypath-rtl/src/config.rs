use raypath_ops::{JobKind, Rules};
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// What a datapath can do. The default has all four operations, so that who asks for nothing sees everything.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Config {
    /// The rules on the edges.
    pub rules: Rules,
    /// The distance modes (Table VI, `support_euclidean`).
    pub lanes: Lanes,
}

/// How many dimensions a Euclidean beat has; an angular one has half as many.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Lanes {
    /// The distance modes are off: their ports, registers and units are not there.
    None,
    /// 16 Euclidean lanes, 8 angular ones.
    #[default]
    Sixteen,
}

/// A number of lanes that there is no datapath for.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("'{0}' lanes, expected none or 16")]
pub struct ParseLanesError(String);

impl Config {
    /// The jobs that it answers.
    pub fn kinds(self) -> &'static [JobKind] {
        match self.lanes {
            Lanes::None => &[JobKind::Triangle, JobKind::Quadbox],
            Lanes::Sixteen => &JobKind::ALL,
        }
    }
}

impl FromStr for Lanes {
    type Err = ParseLanesError;
    fn from_str(lanes: &str) -> Result<Self, ParseLanesError> {
        match lanes {
            "none" => Ok(Lanes::None),
            "16" => Ok(Lanes::Sixteen),
            _ => Err(ParseLanesError(lanes.to_string())),
        }
    }
}

impl fmt::Display for Lanes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Lanes::None => "none",
            Lanes::Sixteen => "16",
        })
    }
}

impl fmt::Display for Config {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "lanes {}, rules {}", self.lanes, self.rules)
    }
}
