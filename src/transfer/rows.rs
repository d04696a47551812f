//! Particle arrays as the kernels see them: bins own disjoint ranges of rows, so they may be worked on side by side.

use crate::basis::{Batch, Places};
use crate::material::{History, MAX_HISTORY};
use crate::model::Model;
use crate::state::{Particles, Table};
use std::marker::PhantomData;

/// Pointers to the columns of a table.
#[derive(Clone, Copy)]
pub(crate) struct Columns<const N: usize>([*mut f64; N]);

impl<const N: usize> Columns<N> {
    fn new(table: &mut Table) -> Self {
        let mut columns = [std::ptr::null_mut(); N];
        for (pointer, column) in columns.iter_mut().zip(table.columns_mut()) {
            *pointer = column.as_mut_ptr();
        }
        Self(columns)
    }

    /// Number `row` of a column.
    ///
    /// # Safety
    /// There is such a column, with such a row.
    #[inline(always)]
    pub(crate) unsafe fn at(&self, column: usize, row: usize) -> *mut f64 {
        // SAFETY: the caller's promise.
        unsafe { self.0[column].add(row) }
    }
}

/// Write access to the particles from several threads.
///
/// # Safety contract
/// Each row is used by one thread at a time: kernels take the rows of their own bin only. Rows are below the number of particles and
/// component numbers below the width of their table; the kernels take both from the bins and from the dimension.
#[derive(Clone, Copy)]
pub(crate) struct Rows<'a> {
    pub(crate) position: Columns<3>,
    pub(crate) velocity: Columns<3>,
    pub(crate) deformation: Columns<9>,
    pub(crate) affine: Columns<9>,
    pub(crate) history: Columns<MAX_HISTORY>,
    history_width: usize,
    lateral: *mut f64,
    mass: *mut f64,
    volume: *mut f64,
    body: *mut u16,
    id: *mut u32,
    owner: PhantomData<&'a mut Particles>,
}

// SAFETY: see the contract above; the pointers come from one `&mut Particles` that outlives the rows.
unsafe impl Send for Rows<'_> {}
// SAFETY: as above.
unsafe impl Sync for Rows<'_> {}

impl<'a> Rows<'a> {
    pub(crate) fn new(particles: &'a mut Particles) -> Self {
        let lateral = particles.lateral.columns_mut().next().map_or(std::ptr::null_mut(), |c| c.as_mut_ptr());
        Self {
            position: Columns::new(&mut particles.position),
            velocity: Columns::new(&mut particles.velocity),
            deformation: Columns::new(&mut particles.deformation),
            affine: Columns::new(&mut particles.affine),
            history: Columns::new(&mut particles.history),
            history_width: particles.history.width(),
            lateral,
            mass: particles.mass.as_mut_ptr(),
            volume: particles.volume.as_mut_ptr(),
            body: particles.body.as_mut_ptr(),
            id: particles.id.as_mut_ptr(),
            owner: PhantomData,
        }
    }

    /// The same rows with the velocities of another table.
    pub(crate) fn with_velocity(self, velocity: &'a mut Table) -> Self {
        Self { velocity: Columns::new(velocity), ..self }
    }

    /// Mass of row `p` \[kg\], with those of the rows that follow behind it.
    ///
    /// # Safety
    /// As the contract of [`Rows`] says.
    #[inline(always)]
    pub(crate) unsafe fn mass(&self, p: usize) -> *const f64 {
        // SAFETY: the caller keeps the contract.
        unsafe { self.mass.add(p) }
    }

    /// Volume of row `p` at time 0 \[m3\], with those of the rows that follow behind it.
    ///
    /// # Safety
    /// As the contract of [`Rows`] says.
    #[inline(always)]
    pub(crate) unsafe fn volume(&self, p: usize) -> *const f64 {
        // SAFETY: the caller keeps the contract.
        unsafe { self.volume.add(p) }
    }

    /// Body of row `p`.
    ///
    /// # Safety
    /// As the contract of [`Rows`] says.
    #[inline(always)]
    pub(crate) unsafe fn body(&self, p: usize) -> usize {
        // SAFETY: the caller keeps the contract.
        usize::from(unsafe { *self.body.add(p) })
    }

    /// Puts row `start + order[p]` at place `start + p`. Velocities and affine matrices stay where they are unless they are `kept`.
    ///
    /// # Safety
    /// As the contract of [`Rows`] says; `order` holds the numbers below its length.
    pub(super) unsafe fn permute(&self, model: &Model, start: usize, order: &[u32], kept: bool, spare: &mut Spare) {
        let (d, tensor) = (model.dimension, model.dimension * model.dimension);
        let affine = if kept && model.needs.affine { tensor } else { 0 };
        let tables: [(&[*mut f64], usize); 5] = [
            (&self.position.0, d),
            (&self.deformation.0, tensor),
            (&self.history.0, self.history_width),
            (&self.velocity.0, if kept { d } else { 0 }),
            (&self.affine.0, affine),
        ];
        // SAFETY: the caller keeps the contract.
        unsafe {
            for (columns, width) in tables {
                columns[..width].iter().for_each(|column| permute(column.add(start), order, &mut spare.numbers));
            }
            if !self.lateral.is_null() {
                permute(self.lateral.add(start), order, &mut spare.numbers);
            }
            permute(self.mass.add(start), order, &mut spare.numbers);
            permute(self.volume.add(start), order, &mut spare.numbers);
            permute(self.body.add(start), order, &mut spare.bodies);
            permute(self.id.add(start), order, &mut spare.ids);
        }
    }

    /// The first `D` numbers of row `p`.
    ///
    /// # Safety
    /// As the contract of [`Rows`] says.
    #[inline(always)]
    pub(crate) unsafe fn vector<const D: usize, const N: usize>(&self, columns: &Columns<N>, p: usize) -> [f64; D] {
        // SAFETY: the caller keeps the contract.
        std::array::from_fn(|a| unsafe { *columns.0[a].add(p) })
    }

    /// Where the rows from `start` to below `end` are; the last row again where there are fewer than eight.
    ///
    /// # Safety
    /// As the contract of [`Rows`] says; `start` is below `end`.
    #[inline(always)]
    pub(crate) unsafe fn places<const D: usize>(&self, model: &Model, start: usize, end: usize) -> Places<D> {
        let row = |l: usize| (start + l).min(end - 1);
        // SAFETY: the caller keeps the contract.
        let position = std::array::from_fn(|a| std::array::from_fn(|l: usize| unsafe { *self.position.0[a].add(row(l)) }));
        let half = match model.domains {
            None => [Batch::default(); D],
            Some(follow) => std::array::from_fn(|a| {
                std::array::from_fn(|l: usize| {
                    // SAFETY: the caller keeps the contract.
                    let stretch = if follow { unsafe { *self.deformation.0[a * (D + 1)].add(row(l)) } } else { 1.0 };
                    // SAFETY: as above.
                    let body = unsafe { self.body(row(l)) };
                    model.bodies[body].half[a] * stretch
                })
            }),
        };
        Places { position, half }
    }

    /// The same with as many axes as the model has; those beyond it are zero.
    ///
    /// # Safety
    /// As the contract of [`Rows`] says; `start` is below `end`.
    pub(crate) unsafe fn places_3(&self, model: &Model, start: usize, end: usize) -> Places<3> {
        fn widen<const D: usize>(p: Places<D>) -> Places<3> {
            let wide = |b: [Batch; D]| std::array::from_fn(|a| b.get(a).copied().unwrap_or_default());
            Places { position: wide(p.position), half: wide(p.half) }
        }
        // SAFETY: the caller keeps the contract.
        unsafe {
            match model.dimension {
                1 => widen(self.places::<1>(model, start, end)),
                2 => widen(self.places::<2>(model, start, end)),
                _ => self.places::<3>(model, start, end),
            }
        }
    }

    /// # Safety
    /// As the contract of [`Rows`] says.
    #[inline(always)]
    pub(crate) unsafe fn set_vector<const D: usize, const N: usize>(&self, columns: &Columns<N>, p: usize, value: [f64; D]) {
        for a in 0..D {
            // SAFETY: the caller keeps the contract.
            unsafe { *columns.0[a].add(p) = value[a] }
        }
    }

    /// Row `p` as a D x D tensor.
    ///
    /// # Safety
    /// As the contract of [`Rows`] says.
    #[inline(always)]
    pub(crate) unsafe fn tensor<const D: usize>(&self, columns: &Columns<9>, p: usize) -> [[f64; D]; D] {
        // SAFETY: the caller keeps the contract.
        std::array::from_fn(|r| std::array::from_fn(|c| unsafe { *columns.0[r * D + c].add(p) }))
    }

    /// # Safety
    /// As the contract of [`Rows`] says.
    #[inline(always)]
    pub(crate) unsafe fn set_tensor<const D: usize>(&self, columns: &Columns<9>, p: usize, value: [[f64; D]; D]) {
        for r in 0..D {
            for c in 0..D {
                // SAFETY: the caller keeps the contract.
                unsafe { *columns.0[r * D + c].add(p) = value[r][c] }
            }
        }
    }

    /// # Safety
    /// As the contract of [`Rows`] says.
    #[inline(always)]
    pub(crate) unsafe fn history(&self, p: usize) -> History {
        // number by number: an array that is written in a loop of unknown length is read back as vectors, for which the processor waits
        // SAFETY: the caller keeps the contract.
        std::array::from_fn(|h| if h < self.history_width { unsafe { *self.history.0[h].add(p) } } else { 0.0 })
    }

    /// # Safety
    /// As the contract of [`Rows`] says.
    #[inline(always)]
    pub(crate) unsafe fn set_history(&self, p: usize, history: &History) {
        for h in 0..MAX_HISTORY {
            if h < self.history_width {
                // SAFETY: the caller keeps the contract.
                unsafe { *self.history.0[h].add(p) = history[h] }
            }
        }
    }

    /// Stretch across the plane; 1 where it is not kept.
    ///
    /// # Safety
    /// As the contract of [`Rows`] says.
    #[inline(always)]
    pub(crate) unsafe fn lateral(&self, p: usize) -> f64 {
        // SAFETY: the caller keeps the contract.
        if self.lateral.is_null() { 1.0 } else { unsafe { *self.lateral.add(p) } }
    }

    /// # Safety
    /// As the contract of [`Rows`] says; there must be a lateral stretch.
    #[inline(always)]
    pub(crate) unsafe fn set_lateral(&self, p: usize, value: f64) {
        // SAFETY: the caller keeps the contract.
        unsafe { *self.lateral.add(p) = value }
    }
}

/// Memory of use to nobody between two calls.
#[derive(Debug, Default)]
pub(super) struct Spare {
    numbers: Vec<f64>,
    bodies: Vec<u16>,
    ids: Vec<u32>,
}

/// Puts number `order[p]` at place p.
///
/// # Safety
/// There are as many numbers as in `order`, which holds the numbers below its length.
unsafe fn permute<T: Copy>(column: *mut T, order: &[u32], spare: &mut Vec<T>) {
    spare.clear();
    // SAFETY: the caller's promise.
    unsafe {
        spare.extend(order.iter().map(|&p| *column.add(p as usize)));
        std::ptr::copy_nonoverlapping(spare.as_ptr(), column, order.len());
    }
}
