/// The lanes of a datapath in which distances are computed: so many Euclidean ones, and half as many angular ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LaneCount {
    /// 2.
    Two,
    /// 4.
    Four,
    /// 8.
    Eight,
    /// 16, as in the paper.
    #[default]
    Sixteen,
    /// 32.
    ThirtyTwo,
    /// 64.
    SixtyFour,
}

impl LaneCount {
    /// All numbers of lanes.
    pub const ALL: [Self; 6] = [Self::Two, Self::Four, Self::Eight, Self::Sixteen, Self::ThirtyTwo, Self::SixtyFour];

    /// This number of Euclidean lanes; `None` unless it is 2, 4, 8, 16, 32 or 64.
    pub fn of(count: usize) -> Option<Self> {
        Self::ALL.into_iter().find(|lanes| lanes.euclidean() == count)
    }

    /// The number of Euclidean lanes.
    pub fn euclidean(self) -> usize {
        2 << self as usize
    }
}

/// An expression with the numbers of Euclidean and angular lanes as constants.
macro_rules! with_lanes {
    ($lanes:expr, $E:ident, $A:ident => $body:expr) => {
        $crate::lanes::with_lanes!(@ $lanes, $E, $A, $body, Two 2, Four 4, Eight 8, Sixteen 16, ThirtyTwo 32, SixtyFour 64)
    };
    (@ $lanes:expr, $E:ident, $A:ident, $body:expr, $($name:ident $count:literal),*) => {
        match $lanes {
            $($crate::LaneCount::$name => {
                const $E: usize = $count;
                const $A: usize = $E / 2;
                // A body may need one of the two only.
                const _: usize = $A;
                $body
            })*
        }
    };
}
pub(crate) use with_lanes;
