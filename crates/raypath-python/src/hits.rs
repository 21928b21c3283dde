//! The outcomes of arrays of boxes, triangles and rays.

use pyo3::prelude::*;

/// A class around a structured array with a view of each field.
macro_rules! hits {
    ($($doc:literal)+ $name:ident { $($($field_doc:literal)+ $field:ident,)* }) => {
        $(#[doc = $doc])+
        #[pyclass(module = "raypath", frozen)]
        pub struct $name {
            array: Py<PyAny>,
        }

        impl $name {
            pub fn new(array: Bound<'_, PyAny>) -> Self {
                Self { array: array.unbind() }
            }
        }

        #[pymethods]
        impl $name {
            /// The structured array of shape (n,), of which the other attributes are views.
            #[getter]
            fn array<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
                self.array.bind(py).clone()
            }

            $($(#[doc = $field_doc])+
            #[getter]
            fn $field<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
                self.array.bind(py).get_item(stringify!($field))
            })*

            fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
                self.array.bind(py).len()
            }

            fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
                Ok(format!("raypath.{}(n={})", stringify!($name), self.array.bind(py).len()?))
            }
        }
    };
}

hits! {
    " The outcomes of n jobs of a ray against four boxes."
    ""
    " The four boxes of a job are sorted: hits before misses, nearer before farther, equal distances by index."
    QuadboxHits {
        " bool array of shape (n, 4): whether the box at each position of the order is hit."
        is_intersect,
        " float32 array of shape (n, 4): the distance at which the ray enters the box at each position, in units of the"
        " direction's length; 0 if the ray begins inside, infinity for a miss."
        tmin,
        " uint8 array of shape (n, 4): the index of the box at each position among those of the job, 0 to 3."
        box_index,
    }
}

hits! {
    " The outcomes of n jobs of a ray against a triangle."
    ""
    " The distance to the triangle is ``t_num / t_denom``, in units of the direction's length. The datapath does not"
    " divide."
    TriangleHits {
        " bool array of shape (n,): whether the ray hits the triangle."
        triangle_hit,
        " float32 array of shape (n,): the numerator of the distance."
        t_num,
        " float32 array of shape (n,): the denominator of the distance."
        t_denom,
    }
}

hits! {
    " The hits of n rays of a ``Unit``."
    ""
    " Values of a ray without a hit are 0, except for ``status``, ``nodes`` and ``triangles``."
    UnitHits {
        " uint32 array of shape (n,): 0 miss, 1 hit, 2 ray refused, 3 error of the memory or of the scene."
        status,
        " uint32 array of shape (n,): the index of the triangle that is hit."
        triangle,
        " uint32 array of shape (n,): with ``instances``, the index of the triangle's instance; 2**32 - 1 for a"
        " triangle in no instance."
        instance,
        " float32 array of shape (n,): the distance of the hit in units of the direction's length."
        t,
        " float32 array of shape (n,): the numerator of the distance."
        t_num,
        " float32 array of shape (n,): the denominator of the distance; negative for a back face."
        t_denom,
        " float32 array of shape (n,): with ``barycentrics``, the weight of the triangle's first vertex at the hit; 0"
        " otherwise. The weights of the three vertices add up to 1."
        u,
        " float32 array of shape (n,): with ``barycentrics``, the weight of the second vertex."
        v,
        " bool array of shape (n,): whether the ray hits the triangle from behind."
        back_face,
        " uint32 array of shape (n,): the nodes that the ray has read."
        nodes,
        " uint32 array of shape (n,): the triangles that the ray has read."
        triangles,
    }
}
