//! Instances: objects that are placed in a scene by an affine transform.
//!
//! A child word of kind 33 refers to the block of an instance. Its words are little-endian:
//!
//! | words of an instance's block | contents |
//! | --- | --- |
//! | those that are no child words of a node, in order | the rows x, y, z of the matrix from the scene to the object, each as x, y, z and t, in binary32 |
//! | where a node has child word 0 | the child word of the object's root: a node or a leaf |
//! | where a node has child word 1 | the index of the instance, which its hits report; all ones are no index |
//! | where a node has child word 2 | bits 23 to 0: the custom index; bits 31 to 24: the mask |
//! | where a node has child word 3 | bits 23 to 0: the offset into the shader table; bits 31 to 24: the [flags](crate::instance_flags) |
//! | others | 0 |
//!
//! The last two words are read with [`Queries::Flags`](crate::Queries::Flags) alone. They are those of Vulkan's
//! `VkAccelerationStructureInstanceKHR`.

use crate::blocks::{NodeKind, child_words, word};
use raypath_ops::{Circuit, Num, Operation, Vec3, bundle};

/// The kind of a child word that refers to an instance.
pub const INSTANCE_KIND: u32 = 33;
/// The jobs of an instance: the ray's origin, then its direction.
pub const INSTANCE_JOBS: u32 = 2;
/// The opcode of [`Transform`] in the unit's datapath.
pub const TRANSFORM_OPCODE: u64 = 4;

/// The bits of custom indices and offsets.
const LOW: u32 = (1 << 24) - 1;

/// An instance, in a block of a node's size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instance {
    /// The rows x, y, z of the matrix from the scene to the object; the last number of each is the translation.
    pub to_object: [[f32; 4]; 3],
    /// The child word of the object's root.
    pub root: u32,
    /// The index that hits report.
    pub index: u32,
    /// The custom index, below 2²⁴.
    pub custom_index: u32,
    /// Rays count it whose mask has a bit of this one.
    pub mask: u8,
    /// The offset into the shader table, below 2²⁴.
    pub shader_offset: u32,
    /// The bits of [`instance_flags`](crate::instance_flags) that are set.
    pub flags: u8,
}

impl Default for Instance {
    /// An instance of nothing, in its own place, for all rays.
    fn default() -> Self {
        let to_object = std::array::from_fn(|row| std::array::from_fn(|column| f32::from(u8::from(row == column))));
        Self { to_object, root: 0, index: 0, custom_index: 0, mask: u8::MAX, shader_offset: 0, flags: 0 }
    }
}

impl Instance {
    /// The instance of an object that this matrix, from the object to the scene, places there. It is inverted in
    /// binary64 and rounded. `None` if it has no inverse, or a number that is not finite in binary32.
    pub fn placed(to_scene: [[f64; 4]; 3], root: u32, index: u32) -> Option<Self> {
        let [x, y, z] = to_scene.map(|[x, y, z, _]| [x, y, z]);
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let columns = [cross(y, z), cross(z, x), cross(x, y)];
        let determinant = dot(x, columns[0]);
        let translation = to_scene.map(|row| row[3]);
        let to_object = std::array::from_fn(|row| {
            let linear = columns.map(|column| column[row] / determinant);
            let [x, y, z] = linear.map(|number| number as f32);
            [x, y, z, -dot(linear, translation) as f32]
        });
        let is_finite = to_object.as_flattened().iter().all(|number: &f32| number.is_finite());
        is_finite.then_some(Self { to_object, root, index, ..Self::default() })
    }

    /// The bytes of the instance's block, in a scene with these nodes.
    pub fn to_bytes(&self, nodes: NodeKind) -> Vec<u8> {
        let with = |high: u8, low: u32| u32::from(high) << 24 | low & LOW;
        let mut words = vec![0; nodes.block_bytes() as usize / 4];
        for (number, value) in self.to_object.as_flattened().iter().enumerate() {
            words[nodes.matrix_word(number)] = value.to_bits();
        }
        let own = [self.root, self.index, with(self.mask, self.custom_index), with(self.flags, self.shader_offset)];
        words[nodes.child_word()..][..own.len()].copy_from_slice(&own);
        words.into_iter().flat_map(u32::to_le_bytes).collect()
    }

    /// The instance in a block of a scene with these nodes; `None` if the block is too short.
    pub fn of(block: &[u8], nodes: NodeKind) -> Option<Self> {
        if block.len() < nodes.block_bytes() as usize {
            return None;
        }
        let number = |number: usize| f32::from_bits(word(block, nodes.matrix_word(number)));
        let [root, index, custom, shader] = child_words(block, nodes);
        Some(Self {
            to_object: std::array::from_fn(|row| std::array::from_fn(|column| number(4 * row + column))),
            root,
            index,
            custom_index: custom & LOW,
            mask: (custom >> 24) as u8,
            shader_offset: shader & LOW,
            flags: (shader >> 24) as u8,
        })
    }
}

bundle! {
    /// A row of an affine transform.
    pub struct Row<C> {
        /// The factor of x.
        pub x: Num<C>,
        /// The factor of y.
        pub y: Num<C>,
        /// The factor of z.
        pub z: Num<C>,
        /// The translation.
        pub t: Num<C>,
    }

    /// A point and an affine transform. A direction is a point of a transform without translation.
    pub struct TransformInput<C> {
        /// The point.
        pub point: Vec3<C>,
        /// The rows of x, y and z.
        pub matrix: [Row<C>; 3],
    }

    /// The point after the transform.
    pub struct TransformOutput<C> {
        /// Each coordinate is ((x + y) + z) + t of its row, rounded after every product and sum.
        pub transformed: Vec3<C>,
    }
}

/// An affine transform of a point: 9 products and 9 sums. A datapath with boxes and triangles needs no more units for
/// it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transform;

impl Operation for Transform {
    const NAME: &'static str = "transform";
    type Input<C: Circuit> = TransformInput<C>;
    type Output<C: Circuit> = TransformOutput<C>;
    type State<C: Circuit> = ();

    #[inline(always)]
    fn run<C: Circuit>(&self, circuit: C, input: TransformInput<C>, _state: ()) -> (TransformOutput<C>, ()) {
        let TransformInput { point, matrix } = input;

        // Triangles subtract in stages 4 and 6. Negated products are subtracted too, so that nothing selects a sign
        // before the adders; the sums are the same.
        circuit.stage(3, "products of the matrix and the point");
        let products = matrix.map(|row| Vec3 { x: row.x * point.x, y: -(row.y * point.y), z: -(row.z * point.z) });
        circuit.label(format_args!("product"), &products);

        circuit.stage(4, "x + y of each row");
        let xy = products.map(|product| product.x - product.y);
        circuit.label(format_args!("row_xy"), &xy);

        circuit.stage(6, "+ z of each row");
        let [x, y, z] = [xy[0] - products[0].z, xy[1] - products[1].z, xy[2] - products[2].z];
        circuit.label(format_args!("row_xyz"), &[x, y, z]);

        // Two adders in either stage.
        circuit.stage(8, "+ t of x and y");
        let (x, y) = (x + matrix[0].t, y + matrix[1].t);
        circuit.stage(9, "+ t of z");
        let transformed = Vec3 { x, y, z: z + matrix[2].t };
        circuit.label(format_args!("transformed"), &transformed);
        (TransformOutput { transformed }, ())
    }
}
