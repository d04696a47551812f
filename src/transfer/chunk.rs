//! What is known of a few particles between the stages of a sweep, component by component.

use crate::lanes::{Batch, LANES, MOST_LANES, Mask, Number, Quad, Real};

/// Particles of a chunk. Few enough for their numbers to stay in the cache of a core, enough for the stages to overlap.
pub(super) const CHUNK: usize = 64;

/// Cells whose nodes are at hand: two that are taken from, and the next.
pub(super) const CELLS: usize = 4;

/// A number a particle. All lanes may be written wherever a particle is, so there is room for some that are not there.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Column<N>(pub(super) [N; CHUNK + MOST_LANES]);

impl<N: Number> Column<N> {
    /// That of a particle of the chunk.
    #[inline(always)]
    pub(super) fn number(&self, at: usize) -> f64 {
        self.0[at].into()
    }
}

/// Memory of a sweep; of use to nobody after it.
#[repr(C, align(64))]
pub(super) struct Chunk<const W: usize, V: Real> {
    pub(super) fields: Fields<V::Number>,
    /// As many particles each as there are lanes.
    pub(super) packets: [Packets<W, V>; CHUNK / LANES],
    /// The nodes of the cells that are taken from and of the next, in turns.
    pub(super) cells: [Cell<W, V::Number>; CELLS],
}

/// What is known of each particle.
#[repr(C, align(64))]
pub(super) struct Fields<N> {
    /// Where it is in its cell, by axis, see [`super::functions::Local`].
    pub(super) xi: [Column<N>; 3],
    pub(super) length: [Column<N>; 3],
    /// Velocity of the grid, later of the particle.
    pub(super) velocity: [Column<N>; 3],
    /// Acceleration of the grid; the first is a mark (see `Stepper::mark_held_nodes`).
    pub(super) acceleration: [Column<N>; 4],
    /// Derivative of the velocity of the grid, by component and axis.
    pub(super) gradient: [[Column<N>; 3]; 3],
    /// Affine matrix, by component and axis.
    pub(super) affine: [[Column<N>; 3]; 3],
    /// -V0 tau, times the kick where forces are merged with momenta; at least that half of which the first number is not above the second.
    pub(super) force: [[Column<N>; 3]; 3],
    /// Index of the first node of each particle in the tile of its bin.
    pub(super) node: [u32; CHUNK + LANES],
    /// Particles that are not in the cell of the one before, a bit each.
    begins: u64,
    /// Particles of each eight whose functions are not those of inner cells.
    outside: [Mask; CHUNK / LANES + 1],
}

impl<N: Number> Fields<N> {
    /// Whether the functions at particle `at` are those of inner cells.
    #[inline(always)]
    pub(super) fn is_inner(&self, at: usize) -> bool {
        self.outside[at % CHUNK / LANES] >> (at % LANES) & 1 == 0
    }

    /// Whether those at `count` particles from `at` on are, the first of an eight.
    #[inline(always)]
    pub(super) fn are_inner(&self, at: usize, count: usize) -> bool {
        let eight = at % CHUNK / LANES;
        let outside = u32::from(self.outside[eight]) | u32::from(self.outside[eight + 1]) << LANES;
        outside & ((1 << count) - 1) == 0
    }

    /// Says which of the eight particles from `at` on have other functions.
    #[inline(always)]
    pub(super) fn set_outside(&mut self, at: usize, outside: Mask) {
        self.outside[at % CHUNK / LANES] = outside;
    }

    /// Notes where runs of particles in one cell begin.
    #[inline(always)]
    pub(super) fn mark_runs(&mut self) {
        let mut begins = 0;
        for l in 1..CHUNK {
            begins |= u64::from(self.node[l] != self.node[l - 1]) << l;
        }
        self.begins = begins;
    }

    /// The end of the run of particles from `start` on, below `end`, that are in one cell. Runs must have been marked. No loop: the processor
    /// would have to guess how long each is.
    #[inline(always)]
    pub(super) fn end_of_run(&self, start: usize, end: usize) -> usize {
        let later = self.begins >> (start % CHUNK) >> 1;
        end.min(start + 1 + later.trailing_zeros() as usize)
    }
}

/// The nodes of a cell, slot by slot as the middle one and the differences of the others from it: weights sum to 1 and slopes to 0, so
/// the middle one needs neither. All particles of the cell share them.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Cell<const W: usize, N> {
    /// By node of slots 0 and 1: two of the others along slot 2 each, in their order; at the end the middle one twice.
    pub(super) rows: [[[Batch<N>; 4]; W]; W],
}

/// What a particle a lane adds to the grid.
///
/// A particle adds to node (i, j, k) the field f = N_i N_j N_k b + e0_i N_j N_k + N_i e1_j N_k + N_i N_j e2_k with b of mass and momentum, and
/// e of what grows with the distance (the affine matrix) or goes by a slope (the stress). As the sum of all N is 1 and that of all
/// slopes and arms 0, the sum of f along an axis is that of the N of the other axes: in inner cells it takes the place of the middle node.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Packets<const W: usize, V: Real> {
    pub(super) base: V::Quads,
    /// e by slot and node; along slots 0 and 1 that of the middle node is not kept.
    pub(super) more: [[V::Quads; W]; 3],
    /// N by slot and node.
    pub(super) value: [[V::Lanes; W]; 3],
}

impl<const W: usize, V: Real> Packets<W, V> {
    /// b of a lane.
    #[inline(always)]
    pub(super) fn base(&self, lane: usize) -> &Quad<V::Number> {
        &self.base.as_ref()[V::slot(lane)]
    }
    /// e of a lane.
    #[inline(always)]
    pub(super) fn more(&self, slot: usize, node: usize, lane: usize) -> &Quad<V::Number> {
        &self.more[slot][node].as_ref()[V::slot(lane)]
    }
    /// N of a lane.
    #[inline(always)]
    pub(super) fn value(&self, slot: usize, node: usize, lane: usize) -> V::Number {
        self.value[slot][node].as_ref()[lane]
    }
}

/// Memory for the chunks of one thread.
#[derive(Debug, Default)]
pub(crate) struct ChunkMemory(Vec<Aligned>);

#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct Aligned([f64; LANES]);

impl ChunkMemory {
    /// A chunk of any content.
    pub(super) fn chunk<const W: usize, V: Real>(&mut self) -> &mut Chunk<W, V> {
        let lines = size_of::<Chunk<W, V>>() / size_of::<Aligned>();
        if self.0.len() < lines {
            self.0.resize(lines, Aligned([0.0; LANES]));
        }
        // SAFETY: the memory is as large and as aligned as a chunk, and a chunk is made of numbers, for which any bits will do.
        unsafe { &mut *self.0.as_mut_ptr().cast::<Chunk<W, V>>() }
    }
}

/// The numbers of all lanes from a particle of the chunk on.
#[inline(always)]
pub(super) fn load<V: Real>(column: &Column<V::Number>, at: usize) -> V {
    // SAFETY: there is room for all lanes from any particle on.
    unsafe { V::load(column.0.as_ptr().add(at % CHUNK)) }
}

/// Writes the numbers of all lanes from a particle of the chunk on.
#[inline(always)]
pub(super) fn store<V: Real>(column: &mut Column<V::Number>, at: usize, value: V) {
    // SAFETY: there is room for all lanes from any particle on.
    unsafe { value.store(column.0.as_mut_ptr().add(at % CHUNK)) }
}

/// Eight numbers from a particle of the chunk on.
#[inline(always)]
pub(super) fn load_eight<V: Real>(column: &Column<V::Number>, at: usize) -> V::Wide {
    // SAFETY: there is room for eight numbers from any particle on.
    V::load_eight(unsafe { &*column.0.as_ptr().add(at % CHUNK).cast() })
}

/// Writes eight numbers from a particle of the chunk on.
#[inline(always)]
pub(super) fn store_eight<V: Real>(column: &mut Column<V::Number>, at: usize, value: V::Wide) {
    // SAFETY: there is room for eight numbers from any particle on.
    V::store_eight(value, unsafe { &mut *column.0.as_mut_ptr().add(at % CHUNK).cast() });
}
