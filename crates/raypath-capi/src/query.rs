//! Rays of a traversal unit whose caller decides about candidates.

use crate::Unit;
use crate::memory::{array, free, reference, reference_mut, results, separate};
use crate::status::{RAYPATH_OK, Status, status};
use raypath_embed::{self as embed, UnitCandidate, UnitHit, UnitRay, UnitVerdict};
use std::ffi::c_void;

/// `raypath_query_proceed`: the ray waits for a verdict on a candidate.
pub const RAYPATH_CANDIDATE: Status = 1;

/// A ray that waits for its caller at each candidate, as `rayQueryEXT` does. One thread at a time may use it.
pub struct Query(embed::UnitQuery);

/// Decides about a candidate: sets `*verdict`, which ignores it before. `user` is that of `raypath_unit_trace_with`.
pub type Decide =
    Option<unsafe extern "C" fn(user: *mut c_void, candidate: *const UnitCandidate, verdict: *mut UnitVerdict)>;

/// Begins a query with a ray, and sets `*query`. The unit may be closed before the query. Only a unit with
/// `queries = "full"` has candidates.
///
/// Errors: `RAYPATH_ERROR_ARGUMENT` for flags, a mask or a base out of range; `RAYPATH_ERROR_NULL`, `_ALIGNMENT`.
///
/// # Safety
/// `unit` is NULL or an open unit; `ray` is NULL or points to a structure; `query` is NULL or points to a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_query_new(unit: *const Unit, ray: *const UnitRay, query: *mut *mut Query) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (unit, ray, query) =
            unsafe { (reference("unit", unit)?, reference("ray", ray)?, reference_mut("query", query)?) };
        *query = Box::into_raw(Box::new(Query(unit.embedded.query(ray)?)));
        Ok(RAYPATH_OK)
    })
}

/// Goes on through a scene of `size` bytes. Returns `RAYPATH_CANDIDATE` with `*candidate` if the ray waits for a verdict,
/// or `RAYPATH_OK` if it has ended. A candidate without `raypath_query_answer` is ignored.
///
/// Errors: `RAYPATH_ERROR_NULL`, `_ALIGNMENT`.
///
/// # Safety
/// `query` is NULL or a query that no other thread uses; `scene` is NULL or has `size` elements; `candidate` is NULL or
/// points to a structure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_query_proceed(
    query: *mut Query,
    scene: *const u8,
    size: usize,
    candidate: *mut UnitCandidate,
) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (query, scene, candidate) = unsafe {
            (reference_mut("query", query)?, array("scene", scene, size)?, reference_mut("candidate", candidate)?)
        };
        let Some(found) = query.0.proceed(scene) else { return Ok(RAYPATH_OK) };
        *candidate = found;
        Ok(RAYPATH_CANDIDATE)
    })
}

/// Decides about the candidate for which the ray waits.
///
/// Errors: `RAYPATH_ERROR_NULL`, `_ALIGNMENT`.
///
/// # Safety
/// `query` is NULL or a query that no other thread uses; `verdict` is NULL or points to a structure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_query_answer(query: *mut Query, verdict: *const UnitVerdict) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (query, verdict) = unsafe { (reference_mut("query", query)?, reference("verdict", verdict)?) };
        query.0.answer(*verdict);
        Ok(RAYPATH_OK)
    })
}

/// Sets `*hit` to that of a ray that has ended.
///
/// Errors: `RAYPATH_ERROR_ARGUMENT` before; `RAYPATH_ERROR_NULL`, `_ALIGNMENT`.
///
/// # Safety
/// `query` is NULL or a query; `hit` is NULL or points to a structure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_query_hit(query: *const Query, hit: *mut UnitHit) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (query, hit) = unsafe { (reference("query", query)?, reference_mut("hit", hit)?) };
        let problem = || embed::Error::Argument("the ray of the query has not ended".to_string());
        *hit = query.0.hit().ok_or_else(problem)?;
        Ok(RAYPATH_OK)
    })
}

/// Frees a query. NULL is ignored.
///
/// # Safety
/// `query` is NULL or came from `raypath_query_new` and was not freed; no other call uses it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_query_free(query: *mut Query) {
    // SAFETY: by the contract of this function.
    unsafe { free(query) };
}

/// As `raypath_unit_trace`, with a function that decides about the candidates of each ray, in the order in which the ray
/// meets them; NULL accepts triangles and ignores boxes. `user` is passed on to it.
///
/// Errors: those of `raypath_unit_trace`.
///
/// # Safety
/// That of `raypath_unit_trace`; `decide` uses none of the arrays but to read them, and does not unwind.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)] // arrays of C
pub unsafe extern "C" fn raypath_unit_trace_with(
    unit: *const Unit,
    scene: *const u8,
    size: usize,
    rays: *const UnitRay,
    count: usize,
    hits: *mut UnitHit,
    decide: Decide,
    user: *mut c_void,
) -> Status {
    status(|| {
        let to = ("hits", hits.cast_const(), count);
        separate(("scene", scene, size), to)?;
        separate(("rays", rays, count), to)?;
        // SAFETY: by the contract of this function; the hits overlap nothing.
        let (unit, scene, rays, hits) = unsafe {
            (
                reference("unit", unit)?,
                array("scene", scene, size)?,
                array("rays", rays, count)?,
                results("hits", hits, count)?,
            )
        };
        let Some(decide) = decide else {
            unit.embedded.trace(scene, rays, hits)?;
            return Ok(RAYPATH_OK);
        };
        let mut decide = |candidate: &UnitCandidate| {
            let mut verdict = UnitVerdict::default();
            // SAFETY: by the contract of this function.
            unsafe { decide(user, candidate, &raw mut verdict) };
            verdict
        };
        unit.embedded.trace_with(scene, rays, hits, &mut decide)?;
        Ok(RAYPATH_OK)
    })
}
