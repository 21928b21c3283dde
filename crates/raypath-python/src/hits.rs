//! The outcomes of arrays of boxes, triangles and rays: structured arrays that index, iterate and pickle.

use crate::array::{Item, dtype};
use crate::error::value_error;
use numpy::{PyArrayDescrMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator, PyString};
use raypath_embed::{QuadboxResult, TriangleResult, UnitHit};

/// A hit of `raypath.trace`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default)]
pub struct TraceHit {
    /// The index of the triangle; -1 for a miss.
    pub triangle: i32,
    pub t: f32,
    pub t_num: f32,
    pub t_denom: f32,
    /// 0 or 1.
    pub back_face: u32,
}

/// The array, if it has one dimension and elements of `T`.
fn rows_of<T: Item>(py: Python<'_>, array: Py<PyAny>) -> PyResult<Py<PyAny>> {
    let expected = dtype::<T>(py)?;
    let is_such = |array: &Bound<'_, PyUntypedArray>| array.ndim() == 1 && array.dtype().is_equiv_to(&expected);
    match array.bind(py).cast::<PyUntypedArray>() {
        Ok(found) if is_such(found) => Ok(array),
        _ => Err(value_error("array: found another object, expected the structured array of such hits")),
    }
}

/// A class around a structured array with a view of each field.
macro_rules! hits {
    ($($doc:literal)+ $name:ident of $item:ty { $($($field_doc:literal)+ $field:ident,)* } $($extra:item)*) => {
        $(#[doc = $doc])+
        ///
        /// They have a length, iterate, and index: by a field's name, by a number for one, by a slice or an array for
        /// several. ``pandas.DataFrame(hits.array)`` has a column for each field of one number.
        #[pyclass(module = "raypath", frozen)]
        pub struct $name {
            array: Py<PyAny>,
            timing: Option<Py<PyDict>>,
        }

        impl $name {
            pub fn of(array: Bound<'_, PyAny>, timing: Option<Bound<'_, PyDict>>) -> Self {
                Self { array: array.unbind(), timing: timing.map(Bound::unbind) }
            }
        }

        #[pymethods]
        impl $name {
            #[new]
            #[pyo3(signature = (array, timing = None))]
            fn new(py: Python<'_>, array: Py<PyAny>, timing: Option<Py<PyDict>>) -> PyResult<Self> {
                Ok(Self { array: rows_of::<$item>(py, array)?, timing })
            }

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

            fn __getitem__<'py>(&self, key: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
                let (py, found) = (key.py(), self.array.bind(key.py()).get_item(key)?);
                if key.is_instance_of::<PyString>() || !found.is_instance_of::<PyUntypedArray>() {
                    return Ok(found);
                }
                Ok(Bound::new(py, Self { array: found.unbind(), timing: None })?.into_any())
            }

            fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
                self.array.bind(py).try_iter()
            }

            fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
                self.array.bind(py).len()
            }

            fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
                Ok(format!("raypath.{}(n={})", stringify!($name), self.array.bind(py).len()?))
            }

            /// The arguments that make equal hits, for ``pickle``.
            fn __getnewargs__(&self, py: Python<'_>) -> (Py<PyAny>, Option<Py<PyDict>>) {
                (self.array.clone_ref(py), self.timing.as_ref().map(|timing| timing.clone_ref(py)))
            }

            $($extra)*
        }
    };
}

hits! {
    " The outcomes of n jobs of a ray against four boxes."
    ""
    " The four boxes of a job are sorted: hits before misses, nearer before farther, equal distances by index."
    QuadboxHits of QuadboxResult {
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
    TriangleHits of TriangleResult {
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
    " A ray without a hit has ``primitive``, ``geometry`` and ``instance`` -1 and ``t`` infinity; its other values are 0,"
    " except for ``status``, ``nodes`` and ``triangles``."
    UnitHits of UnitHit {
        " uint32 array of shape (n,): a ``UnitStatus``: 0 miss, 1 hit of a triangle, 2 of a box, 3 ray refused, 4 error of"
        " the memory, 5 error of the scene, 6 limit of work."
        status,
        " int32 array of shape (n,): the index, in its geometry, of the triangle that is hit; -1 for a miss."
        primitive,
        " int32 array of shape (n,): with ``instances``, the index of the triangle's instance; -1 for a triangle in no"
        " instance, and for a miss."
        instance,
        " float32 array of shape (n,): the distance of the hit in units of the direction's length; infinity for a miss."
        t,
        " float32 array of shape (n,): the numerator of the distance."
        t_num,
        " float32 array of shape (n,): the denominator of the distance; negative if the vertices run clockwise as the"
        " ray's origin sees them."
        t_denom,
        " float32 array of shape (n,): with ``barycentrics``, the weight of the triangle's second vertex at the hit;"
        " 0 otherwise. The weights of the three vertices add up to 1."
        u,
        " float32 array of shape (n,): with ``barycentrics``, the weight of the third vertex."
        v,
        " bool array of shape (n,): whether the ray hits the triangle from behind."
        back_face,
        " uint32 array of shape (n,): the nodes that the ray has read."
        nodes,
        " uint32 array of shape (n,): the triangles that the ray has read."
        triangles,
        " int32 array of shape (n,): the index of the triangle's geometry; -1 for a miss."
        geometry,
        " uint32 array of shape (n,): with ``instances`` and ``queries``, the custom index of the instance; 0 otherwise."
        custom_index,
        " uint32 array of shape (n,): with ``instances`` and ``queries``, the offset of the instance into the shader table;"
        " 0 otherwise."
        shader_offset,
    }
}

hits! {
    " The closest hits of n rays, and their simulated timing."
    Trace of TraceHit {
        " int32 array of shape (n,): the index of the triangle that is hit; -1 for a miss."
        triangle,
        " float32 array of shape (n,): the distance of the hit in units of the direction's length; infinity for a miss."
        t,
        " float32 array of shape (n,): the numerator of the distance; 0 for a miss."
        t_num,
        " float32 array of shape (n,): the denominator of the distance; 0 for a miss."
        t_denom,
        " bool array of shape (n,): whether the ray hits the triangle from behind."
        back_face,
    }

    /// The figures of the simulation (see ``raypath.render``), or None without ``timed``. An agent is a ray.
    #[getter]
    fn timing(&self, py: Python<'_>) -> Option<Py<PyDict>> {
        self.timing.as_ref().map(|timing| timing.clone_ref(py))
    }
}
