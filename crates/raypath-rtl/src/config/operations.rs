//! The operations of a configuration, for hardware and models alike.

use super::declarations::Semantics;
use super::enumerations::{Accumulators, Lanes};
use raypath_ops::{
    Angular, AngularMany, Euclidean, EuclideanMany, JobKind, Operation, RayBox, RayBoxConservative, RayTriangle,
    RayTriangleExtended,
};

/// Receives the operations of a configuration, one after another.
pub trait OperationVisitor {
    /// The reason to stop.
    type Error;

    /// Receives an operation and its opcode.
    ///
    /// # Errors
    /// The visitor's own. After an error it receives no further operation.
    fn visit<O: Operation + Send + Sync + 'static>(&mut self, operation: O, opcode: u64) -> Result<(), Self::Error>;
}

impl Semantics {
    /// Shows the operations to a visitor, in the order of ports, tables and comments. The operations do not handle the
    /// tag or the exception flags, which are the same for any operation.
    ///
    /// # Errors
    /// Those of the visitor.
    pub fn operations<V: OperationVisitor>(self, visitor: &mut V) -> Result<(), V::Error> {
        let (rules, features) = (self.rules_in_full(), self.features);
        if features.conservative {
            visitor.visit(RayBoxConservative, JobKind::Quadbox.opcode())?;
        } else {
            visitor.visit(RayBox { rules }, JobKind::Quadbox.opcode())?;
        }
        if features.extend_triangles() {
            let (culling, facing) = (features.culling, features.facing);
            let (barycentrics, range) = (features.barycentrics, features.range);
            let extended = RayTriangleExtended { rules, culling, facing, barycentrics, range };
            visitor.visit(extended, JobKind::Triangle.opcode())?;
        } else {
            visitor.visit(RayTriangle { rules }, JobKind::Triangle.opcode())?;
        }
        match self.lanes {
            Lanes::None => Ok(()),
            Lanes::Two => distances::<2, 1, V>(features.accumulators, visitor),
            Lanes::Four => distances::<4, 2, V>(features.accumulators, visitor),
            Lanes::Eight => distances::<8, 4, V>(features.accumulators, visitor),
            Lanes::Sixteen => distances::<16, 8, V>(features.accumulators, visitor),
            Lanes::ThirtyTwo => distances::<32, 16, V>(features.accumulators, visitor),
            Lanes::SixtyFour => distances::<64, 32, V>(features.accumulators, visitor),
        }
    }
}

/// The distance operations of `E` and `A` lanes.
fn distances<const E: usize, const A: usize, V: OperationVisitor>(
    accumulators: Accumulators,
    visitor: &mut V,
) -> Result<(), V::Error> {
    match accumulators {
        Accumulators::One => {
            visitor.visit(Euclidean::<E>, JobKind::Euclidean.opcode())?;
            visitor.visit(Angular::<A>, JobKind::Angular.opcode())
        }
        Accumulators::Two => several::<E, A, 2, 1, V>(visitor),
        Accumulators::Four => several::<E, A, 4, 2, V>(visitor),
        Accumulators::Eight => several::<E, A, 8, 3, V>(visitor),
        Accumulators::Sixteen => several::<E, A, 16, 4, V>(visitor),
    }
}

/// The distance operations with `K` accumulators each; a word of `W` bits selects one.
fn several<const E: usize, const A: usize, const K: usize, const W: u32, V: OperationVisitor>(
    visitor: &mut V,
) -> Result<(), V::Error> {
    visitor.visit(EuclideanMany::<E, K, W>, JobKind::Euclidean.opcode())?;
    visitor.visit(AngularMany::<A, K, W>, JobKind::Angular.opcode())
}
