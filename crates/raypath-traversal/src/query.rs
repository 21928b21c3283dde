//! Which primitives count for a ray: its flags and its mask, the words of the instance that it is in, and whether a
//! geometry is opaque. The rules are those of Vulkan's `VK_KHR_ray_query` and of DirectX Raytracing.

use crate::codes::codes;
use crate::words::{WordCircuit, label};
use raypath_ops::{Bit, Circuit, Select, Word, bundle};
use thiserror::Error;

codes! {
    /// The flags of a ray. The bits are those of SPIR-V's `RayFlags`.
    pub mod ray_flags: "RayFlag", "The bits of ray_flags_i.", Some(0);
    /// Every triangle counts as opaque.
    OPAQUE = 1 << 0;
    /// Every triangle counts as non-opaque.
    NO_OPAQUE = 1 << 1;
    /// The ray ends with the first hit that is committed. All triangles of a block are tested before.
    TERMINATE_ON_FIRST_HIT = 1 << 2;
    /// Traversal does not depend on it.
    SKIP_CLOSEST_HIT_SHADER = 1 << 3;
    /// Back faces are not hit.
    CULL_BACK_FACING_TRIANGLES = 1 << 4;
    /// Front faces are not hit.
    CULL_FRONT_FACING_TRIANGLES = 1 << 5;
    /// Primitives that count as opaque are not hit.
    CULL_OPAQUE = 1 << 6;
    /// Primitives that count as non-opaque are not hit.
    CULL_NO_OPAQUE = 1 << 7;
    /// Triangles are not hit.
    SKIP_TRIANGLES = 1 << 8;
    /// Procedural boxes are not hit.
    SKIP_AABBS = 1 << 9;
    {
        /// All of them.
        pub const ALL: u32 = (1 << 10) - 1;
    }
}

codes! {
    /// The flags of an instance, in bits 24 to 31 of the word with its offset. The bits are those of Vulkan's
    /// `VkGeometryInstanceFlagBitsKHR`.
    pub mod instance_flags: "InstanceFlag", "The bits of the word of an instance with its offset that are flags.", Some(24);
    /// Faces are not culled.
    FACING_CULL_DISABLE = 1 << 0;
    /// The back face is the front, and the front the back.
    FLIP_FACING = 1 << 1;
    /// Its geometries count as opaque.
    FORCE_OPAQUE = 1 << 2;
    /// Its geometries count as non-opaque.
    FORCE_NO_OPAQUE = 1 << 3;
    {
        /// All of them.
        pub const ALL: u32 = (1 << 4) - 1;
    }
}

/// What a unit does beside finding hits of opaque triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum Queries {
    /// Nothing: all triangles are opaque, of one geometry, and instances have an index alone.
    #[default]
    None,
    /// Geometries are opaque or not and have an index. Instances have a mask, flags, a custom index and an offset into
    /// the shader table. A hit of a triangle that is not opaque is committed, as where there is no any-hit shader.
    Flags,
    /// As flags, but hits of triangles that are not opaque are candidates, about which a shader decides. Geometries of
    /// procedural boxes exist, and each of their boxes that a ray meets is a candidate.
    Full,
}

/// The order of the vertices of a front face, as the ray's origin sees them in the space of the object, in right-handed
/// axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Front {
    /// Counter-clockwise. These are the front faces of Vulkan and DirectX, which say clockwise in left-handed axes.
    #[default]
    CounterClockwise,
    /// Clockwise.
    Clockwise,
}

/// The error of a name that is none of a parameter's values.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("'{found}', expected {}", expected.join(", "))]
pub struct ParseNameError {
    /// The name.
    pub found: String,
    /// The names of the values.
    pub expected: &'static [&'static str],
}

/// Implements names of values: how they are shown and read.
macro_rules! names {
    ($type:ident { $($value:ident = $name:literal),* }) => {
        impl std::fmt::Display for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(match self { $(Self::$value => $name),* })
            }
        }

        impl std::str::FromStr for $type {
            type Err = $crate::ParseNameError;

            fn from_str(name: &str) -> Result<Self, Self::Err> {
                match name {
                    $($name => Ok(Self::$value),)*
                    _ => Err($crate::ParseNameError { found: name.to_string(), expected: &[$($name),*] }),
                }
            }
        }
    };
}
pub(crate) use names;

names! { Queries { None = "none", Flags = "flags", Full = "full" } }
names! { Front { CounterClockwise = "counter-clockwise", Clockwise = "clockwise" } }

bundle! {
    /// The flags of a ray that decide which primitives count.
    pub struct RayFlags<C> {
        /// [`ray_flags::OPAQUE`].
        pub opaque: Bit<C>,
        /// [`ray_flags::NO_OPAQUE`].
        pub no_opaque: Bit<C>,
        /// [`ray_flags::CULL_BACK_FACING_TRIANGLES`].
        pub cull_back: Bit<C>,
        /// [`ray_flags::CULL_FRONT_FACING_TRIANGLES`].
        pub cull_front: Bit<C>,
        /// [`ray_flags::CULL_OPAQUE`].
        pub cull_opaque: Bit<C>,
        /// [`ray_flags::CULL_NO_OPAQUE`].
        pub cull_no_opaque: Bit<C>,
        /// [`ray_flags::SKIP_TRIANGLES`].
        pub skip_triangles: Bit<C>,
        /// [`ray_flags::SKIP_AABBS`].
        pub skip_boxes: Bit<C>,
    }

    /// The flags of an instance: [`instance_flags`].
    pub struct InstanceFlags<C> {
        /// Faces are not culled.
        pub no_facing_cull: Bit<C>,
        /// Front and back are exchanged.
        pub flipped: Bit<C>,
        /// Geometries count as opaque.
        pub force_opaque: Bit<C>,
        /// Geometries count as non-opaque.
        pub force_no_opaque: Bit<C>,
    }

    /// What a hit reports of its instance.
    pub struct InstanceWords<C> {
        /// The index, or [`NO_INSTANCE`](crate::state::NO_INSTANCE).
        pub index: Word<C, 32>,
        /// The custom index.
        pub custom_index: Word<C, 24>,
        /// The offset into the shader table.
        pub shader_offset: Word<C, 24>,
    }

    /// The triangles that are not hit, by the order of their vertices as the ray's origin sees them.
    pub struct Culls<C> {
        /// Clockwise ones.
        pub clockwise: Bit<C>,
        /// Counter-clockwise ones.
        pub counter_clockwise: Bit<C>,
    }
}

impl<C: WordCircuit> RayFlags<C> {
    /// The flags in a word of [`ray_flags`].
    #[inline(always)]
    pub fn of(word: Word<C, 10>) -> Self {
        let has = |flag: u32| ray_flags::CODES.bit(word, flag);
        Self {
            opaque: has(ray_flags::OPAQUE),
            no_opaque: has(ray_flags::NO_OPAQUE),
            cull_back: has(ray_flags::CULL_BACK_FACING_TRIANGLES),
            cull_front: has(ray_flags::CULL_FRONT_FACING_TRIANGLES),
            cull_opaque: has(ray_flags::CULL_OPAQUE),
            cull_no_opaque: has(ray_flags::CULL_NO_OPAQUE),
            skip_triangles: has(ray_flags::SKIP_TRIANGLES),
            skip_boxes: has(ray_flags::SKIP_AABBS),
        }
    }

    /// Whether they have no meaning: more than one says which primitives are opaque or culled for it, more than one
    /// which triangles are culled, or all primitives are skipped.
    #[inline(always)]
    pub fn are_meaningless(self) -> Bit<C> {
        let both = (self.opaque & self.no_opaque) | (self.cull_opaque & self.cull_no_opaque);
        let mixed = (self.opaque | self.no_opaque) & (self.cull_opaque | self.cull_no_opaque);
        let any_face = (self.cull_back | self.cull_front) & self.skip_triangles;
        let faces = (self.cull_back & self.cull_front) | any_face;
        let c = self.opaque.circuit;
        label!(c: both, mixed, any_face, faces);
        both | mixed | faces | (self.skip_triangles & self.skip_boxes)
    }

    /// Whether a primitive counts as opaque: as its geometry is, if neither the instance nor the ray says otherwise.
    #[inline(always)]
    pub fn is_opaque(self, geometry: Bit<C>, instance: InstanceFlags<C>) -> Bit<C> {
        let of_instance = instance.force_opaque | (geometry & !instance.force_no_opaque);
        geometry.circuit.label(format_args!("is_opaque_by_itself"), &of_instance);
        self.opaque | (of_instance & !self.no_opaque)
    }

    /// Whether boxes or triangles of this opacity are not hit.
    #[inline(always)]
    pub fn skip(self, is_box: Bit<C>, is_opaque: Bit<C>) -> Bit<C> {
        let (c, culled) = (is_box.circuit, is_opaque.select(self.cull_opaque, self.cull_no_opaque));
        let skips = is_box.select(self.skip_boxes, self.skip_triangles) | culled;
        label!(c: culled, skips);
        skips
    }

    /// The triangles that are not hit because of their face.
    #[inline(always)]
    pub fn culls(self, front: Front, instance: InstanceFlags<C>) -> Culls<C> {
        let Self { cull_back, cull_front, .. } = self;
        let (back, front) = match front {
            Front::CounterClockwise => (cull_back, cull_front),
            Front::Clockwise => (cull_front, cull_back),
        };
        let (back, front) = instance.flipped.exchange(back, front);
        let culls = !instance.no_facing_cull;
        Culls { clockwise: back & culls, counter_clockwise: front & culls }
    }

    /// The triangles that are not hit by a unit of [`Queries::None`], where all are opaque.
    #[inline(always)]
    pub fn culls_of_opaque(self, c: C, front: Front) -> Culls<C> {
        let all = self.skip_triangles | self.cull_opaque;
        c.label(format_args!("culls_all"), &all);
        let Culls { clockwise, counter_clockwise } = self.culls(front, InstanceFlags::none(c));
        Culls { clockwise: clockwise | all, counter_clockwise: counter_clockwise | all }
    }
}

impl<C: WordCircuit> InstanceFlags<C> {
    /// The flags of what is in no instance.
    #[inline(always)]
    pub fn none(c: C) -> Self {
        let no = c.bit(false);
        Self { no_facing_cull: no, flipped: no, force_opaque: no, force_no_opaque: no }
    }

    /// The flags in the word of an instance that has its offset, too.
    #[inline(always)]
    pub fn of(word: Word<C, 32>) -> Self {
        let has = |flag: u32| instance_flags::CODES.bit(word, flag);
        Self {
            no_facing_cull: has(instance_flags::FACING_CULL_DISABLE),
            flipped: has(instance_flags::FLIP_FACING),
            force_opaque: has(instance_flags::FORCE_OPAQUE),
            force_no_opaque: has(instance_flags::FORCE_NO_OPAQUE),
        }
    }
}

impl<C: WordCircuit> InstanceWords<C> {
    /// What a hit in no instance reports.
    #[inline(always)]
    pub fn none(c: C) -> Self {
        Self { index: c.word(crate::state::NO_INSTANCE), custom_index: c.word(0), shader_offset: c.word(0) }
    }
}

/// Implements the selection between two bundles, field by field.
macro_rules! select_fields {
    ($($bundle:ident { $($field:ident),* })*) => {$(
        impl<C: Circuit> Select<C> for $bundle<C> {
            #[inline(always)]
            fn select(condition: Bit<C>, if_true: Self, if_false: Self) -> Self {
                Self { $($field: condition.select(if_true.$field, if_false.$field)),* }
            }
        }
    )*};
}
pub(crate) use select_fields;

select_fields! {
    InstanceFlags { no_facing_cull, flipped, force_opaque, force_no_opaque }
    InstanceWords { index, custom_index, shader_offset }
}
