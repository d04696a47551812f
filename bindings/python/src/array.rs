//! Values as numpy arrays, and back.

use crate::convert::kind;
use crate::error::misfit;
use numpy::ndarray::{ArrayViewD, IxDyn};
use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyFloat};
use std::sync::Arc;

/// Keeps values alive while numpy looks at them (the `base` of the array).
#[pyclass(frozen, module = "matpoint")]
struct Values {
    data: Arc<Vec<f64>>,
}

/// A read-only array of the values themselves.
pub(crate) fn view<'py>(py: Python<'py>, values: Arc<Vec<f64>>, shape: &[usize]) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let owner = Bound::new(py, Values { data: values })?;
    let view = ArrayViewD::from_shape(IxDyn(shape), &owner.get().data).map_err(|error| misfit(py, error.to_string()))?;
    // SAFETY: `owner` holds the values: as long as it lives they are not freed, and the simulation does not write to values that are shared
    // (`Simulation::share`). The array is made read-only before anybody sees it.
    let array = unsafe { PyArrayDyn::borrow_from_array(&view, owner.clone().into_any()) };
    array.try_readwrite()?.make_nonwriteable();
    Ok(array)
}

/// A new array with a copy of the values.
pub(crate) fn copy<'py>(py: Python<'py>, values: &[f64], shape: &[usize]) -> Bound<'py, PyArrayDyn<f64>> {
    // SAFETY: the array is new, in C order and as long as the product of its shape, which is the number of values; every number is written
    // before anybody sees it.
    unsafe {
        let array = PyArrayDyn::<f64>::new(py, IxDyn(shape), false);
        std::ptr::copy_nonoverlapping(values.as_ptr(), array.data(), values.len());
        array
    }
}

/// Writes the values into an array that is there.
pub(crate) fn copy_to(py: Python<'_>, values: &[f64], shape: &[usize], out: &Bound<'_, PyAny>, name: &str) -> PyResult<()> {
    let refuse =
        |what: String| misfit(py, format!("`{name}`: out must be a writable C-order array of float64 with shape {shape:?}; {what}"));
    let Ok(array) = out.cast::<PyArrayDyn<f64>>() else {
        let found = out.cast::<PyUntypedArray>().map_or_else(|_| kind(out), |array| format!("an array of {}", array.dtype()));
        return Err(refuse(format!("it is {found}")));
    };
    if array.shape() != shape {
        return Err(refuse(format!("its shape is {:?}", array.shape())));
    }
    if !array.is_c_contiguous() {
        return Err(refuse("it is not in C order".into()));
    }
    let mut array = array.try_readwrite().map_err(|error| refuse(error.to_string()))?;
    let slice = array.as_slice_mut().map_err(|error| refuse(error.to_string()))?;
    slice.copy_from_slice(values);
    Ok(())
}

/// Calls `use_them` with the values that a user gave for a variable of a shape.
pub(crate) fn read<R>(value: &Bound<'_, PyAny>, shape: &[usize], name: &str, use_them: impl FnOnce(&[f64]) -> R) -> PyResult<R> {
    let py = value.py();
    if let Ok(number) = value.cast::<PyFloat>() {
        return Ok(use_them(&[number.value()]));
    }
    let array = match value.cast::<PyArrayDyn<f64>>() {
        Ok(array) => array.clone(),
        Err(_) => convert(value, name)?,
    };
    let found = array.shape();
    let one_number = found.is_empty() && shape.iter().product::<usize>() == 1;
    // where the number of values is wrong, the core says so
    if found != shape && !one_number && array.len() == shape.iter().product::<usize>() {
        return Err(misfit(py, format!("`{name}` has shape {shape:?}, not {found:?}")));
    }
    let array: PyReadonlyArrayDyn<'_, f64> = array.try_readonly().map_err(|error| misfit(py, format!("`{name}`: {error}")))?;
    match array.as_slice() {
        Ok(slice) => Ok(use_them(slice)),
        Err(_) => Ok(use_them(&array.as_array().iter().copied().collect::<Vec<_>>())),
    }
}

/// Lists, other kinds of numbers, anything that numpy reads as real numbers.
fn convert<'py>(value: &Bound<'py, PyAny>, name: &str) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let py = value.py();
    let refuse = |what: String| misfit(py, format!("`{name}` takes real numbers, not {what}"));
    if value.is_instance_of::<PyBool>() {
        return Err(refuse(kind(value)));
    }
    let numpy = py.import("numpy")?;
    let array = numpy.call_method1("asarray", (value,)).map_err(|error| refuse(format!("{} ({error})", kind(value))))?;
    let dtype = array.getattr("dtype")?;
    if !matches!(dtype.getattr("kind")?.extract::<char>()?, 'i' | 'u' | 'f') {
        return Err(refuse(format!("{} of {dtype}", kind(value))));
    }
    Ok(array.call_method1("astype", ("float64",))?.cast_into::<PyArrayDyn<f64>>()?)
}
