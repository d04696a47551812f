//! 3 EVOLVES: all that changes while a scene runs, complete and sufficient for a restart.

mod table;

pub(crate) use table::Table;

use crate::grid::colour;
use serde::{Deserialize, Serialize};

/// The particles, in the order of the blocks of the grid they were last sorted into.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Particles {
    /// Name of the particle: its place in the order the scene made them.
    pub(crate) id: Vec<u32>,
    /// Body, in the order of the scene.
    pub(crate) body: Vec<u16>,
    /// Mass \[kg\].
    pub(crate) mass: Vec<f64>,
    /// Volume at time 0 \[m3\].
    pub(crate) volume: Vec<f64>,
    /// Position \[m\], (n, D).
    pub(crate) position: Table,
    /// Velocity half a step before the time of the state \[m/s\], (n, D).
    pub(crate) velocity: Table,
    /// Deformation gradient \[-\], (n, D D), row by row.
    pub(crate) deformation: Table,
    /// Affine matrix of APIC and ASFLIP \[1/s\], (n, D D), row by row; empty for other transfers.
    pub(crate) affine: Table,
    /// History of the material laws, (n, up to 7); empty for laws without.
    pub(crate) history: Table,
    /// Stretch across the plane or axis \[-\], (n, 1); empty unless stress-free there.
    pub(crate) lateral: Table,
    /// Acceleration \[m/s2\], (n, D); empty but for implicit schemes of the updated formulation that need it.
    pub(crate) acceleration: Table,
}

impl Particles {
    pub(crate) fn len(&self) -> usize {
        self.id.len()
    }

    fn tables(&self) -> [&Table; 7] {
        [&self.position, &self.velocity, &self.deformation, &self.affine, &self.history, &self.lateral, &self.acceleration]
    }

    /// Tables, to be handled alike when particles are sorted.
    pub(crate) fn tables_mut(&mut self) -> [&mut Table; 7] {
        [
            &mut self.position,
            &mut self.velocity,
            &mut self.deformation,
            &mut self.affine,
            &mut self.history,
            &mut self.lateral,
            &mut self.acceleration,
        ]
    }

    /// Exchanges two particles' places in memory.
    fn swap(&mut self, a: usize, b: usize) {
        self.id.swap(a, b);
        self.body.swap(a, b);
        self.mass.swap(a, b);
        self.volume.swap(a, b);
        for table in self.tables_mut() {
            table.columns_mut().for_each(|column| column.swap(a, b));
        }
    }

    /// Memory of one particle \[bytes\].
    pub(crate) fn bytes_each(&self) -> usize {
        4 + 2 + 8 * (2 + self.tables().iter().map(|t| t.width()).sum::<usize>())
    }

    /// Whether every array has the rows and columns of `other`.
    fn fits(&self, other: &Self) -> bool {
        let n = other.len();
        self.id.len() == n
            && [self.mass.len(), self.volume.len(), self.body.len()] == [n; 3]
            && self.position.is(other.position.width(), n)
            && self.velocity.is(other.velocity.width(), n)
            && self.deformation.is(other.deformation.width(), n)
            && self.affine.is(other.affine.width(), n)
            && self.history.is(other.history.width(), n)
            && self.lateral.is(other.lateral.width(), n)
            && self.acceleration.is(other.acceleration.width(), n)
    }
}

/// The particles of one block of cells: a range of the particle arrays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Bin {
    /// Velocity field of its particles: the body where there is contact, else 0.
    pub(crate) field: u16,
    /// Block, in slots (see `basis::Stencils`).
    pub(crate) block: [i32; 3],
    /// Lowest cell of its particles when they were sorted, in slots.
    pub(crate) low: [i32; 3],
    /// Highest cell.
    pub(crate) high: [i32; 3],
    /// First particle.
    pub(crate) start: u32,
    /// One past the last particle.
    pub(crate) end: u32,
}

/// How well the order of the particles still fits the grid.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Order {
    /// Cells that a particle may have moved, at most, since the particles were sorted.
    pub(crate) drift: f64,
    /// Runs of particles in one cell when all were sorted, or 0 where nobody has counted them yet.
    pub(crate) sorted_runs: u64,
    /// The same when each bin was last sorted for itself.
    pub(crate) tidy_runs: u64,
    /// How many more there were since all were sorted than could be, summed over the steps.
    pub(crate) lag: u64,
    /// How many more there were since each bin was sorted than then, summed over the steps.
    pub(crate) excess: u64,
    /// Whether they are to be sorted before the next step.
    pub(crate) is_stale: bool,
}

/// The nodes of the grids that bodies have of their own, body by body; empty in the updated formulation, whose grid forgets.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Nodes {
    /// Displacement \[m\].
    pub(crate) displacement: Vec<[f64; 3]>,
    /// Velocity at the time of the state \[m/s\].
    pub(crate) velocity: Vec<[f64; 3]>,
    /// Acceleration at the time of the state \[m/s2\]; empty for schemes that do not need it.
    pub(crate) acceleration: Vec<[f64; 3]>,
}

/// Whether particles are where the nodes lead them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) enum Shown {
    /// They evolve themselves, or are carried along in every step.
    #[default]
    Always,
    /// All that changes in them follows from the nodes, and has been computed.
    Now,
    /// The same, but the nodes have moved on since.
    Behind,
}

/// All that changes while a scene runs.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct State {
    /// Time \[s\].
    pub(crate) time: f64,
    /// Steps taken.
    pub(crate) steps: u64,
    /// Length of the last step \[s\]; 0 at the start, so that the first step gives half a kick (leapfrog).
    pub(crate) last_step: f64,
    /// Length that the next step may have by the error of the last \[s\]; 0 where steps do not go by their error.
    pub(crate) next_step: f64,
    /// How long before the time of the state the accelerations in it are \[s\].
    pub(crate) acceleration_age: f64,
    /// Smallest ratio of the wave speed at time 0 to wave plus particle speed now: how much of the stable step is left.
    pub(crate) pace: f64,
    /// The particles.
    pub(crate) particles: Particles,
    /// Whether their tables are up to date; where they follow from the nodes, snapshots do not have them.
    #[serde(skip)]
    pub(crate) shown: Shown,
    /// The nodes, where they are remembered.
    pub(crate) nodes: Nodes,
    /// Blocks in the order of the particles.
    pub(crate) bins: Vec<Bin>,
    /// How well they fit.
    pub(crate) order: Order,
    /// Work done on the body by loads and moving boundaries since time 0 \[J\].
    pub(crate) external_work: f64,
    /// Mean force of each boundary on the bodies over the last call of `step` \[N\].
    pub(crate) reactions: Vec<[f64; 3]>,
    /// Values of the loads that are set from outside, by load.
    pub(crate) inputs: Vec<Vec<f64>>,
}

impl State {
    /// Number of the bin of the particle at a place in memory.
    pub(crate) fn bin_of(&self, row: usize) -> usize {
        self.bins.partition_point(|bin| bin.end as usize <= row)
    }

    /// Puts the particles in an order that has nothing to do with their places, always the same; the next step sorts them.
    pub(crate) fn shuffle(&mut self) {
        let mut seed = 0_u64;
        for last in (1..self.particles.len()).rev() {
            // SplitMix64, and a share of it: as even as an order of particles need be
            seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mixed = (seed ^ (seed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            let share = u128::from(mixed ^ (mixed >> 31)) * (last as u128 + 1);
            self.particles.swap(last, (share >> 64) as usize);
        }
        self.bins.clear();
    }

    /// Copies this state into `other`, an empty one or one of the same particles, whose memory is used again.
    pub(crate) fn copy_to(&self, other: &mut Self) {
        let Self {
            time,
            steps,
            last_step,
            next_step,
            acceleration_age,
            pace,
            particles,
            shown,
            nodes,
            bins,
            order,
            external_work,
            reactions,
            inputs,
        } = self;
        other.order = *order;
        (other.time, other.steps, other.pace, other.external_work) = (*time, *steps, *pace, *external_work);
        (other.last_step, other.next_step, other.acceleration_age) = (*last_step, *next_step, *acceleration_age);
        other.nodes.displacement.clone_from(&nodes.displacement);
        other.nodes.velocity.clone_from(&nodes.velocity);
        other.nodes.acceleration.clone_from(&nodes.acceleration);
        other.bins.clone_from(bins);
        other.reactions.clone_from(reactions);
        other.inputs.clone_from(inputs);
        if *shown != Shown::Always && other.shown != Shown::Always && other.particles.len() == particles.len() {
            // what changes in them can be shown again
            other.shown = Shown::Behind;
            return;
        }
        other.shown = *shown;
        let to = &mut other.particles;
        // these never change but for their order
        if to.id != particles.id {
            to.id.clone_from(&particles.id);
            to.body.clone_from(&particles.body);
            to.mass.clone_from(&particles.mass);
            to.volume.clone_from(&particles.volume);
        }
        for (to, from) in to.tables_mut().into_iter().zip(particles.tables()) {
            to.copy_from(from);
        }
    }

    /// What a snapshot has to hold: particles that follow the nodes are left out but for what never changes.
    pub(crate) fn bare(&self) -> std::borrow::Cow<'_, Self> {
        if self.shown == Shown::Always {
            return std::borrow::Cow::Borrowed(self);
        }
        let Particles { id, body, mass, volume, .. } = &self.particles;
        let particles =
            Particles { id: id.clone(), body: body.clone(), mass: mass.clone(), volume: volume.clone(), ..Particles::default() };
        let (nodes, bins, reactions, inputs) = (self.nodes.clone(), self.bins.clone(), self.reactions.clone(), self.inputs.clone());
        std::borrow::Cow::Owned(Self { particles, nodes, bins, reactions, inputs, ..*self })
    }

    /// Gives a state from a snapshot what it left out, as in `other`, to be computed anew.
    pub(crate) fn complete(&mut self, other: &Self) {
        if other.shown != Shown::Always {
            for (to, from) in self.particles.tables_mut().into_iter().zip(other.particles.tables()) {
                to.clone_from(from);
            }
            self.shown = Shown::Behind;
        }
    }

    /// Whether this state can stand in for `other`: same arrays, same loads, sound indices.
    pub(crate) fn fits(&self, other: &Self) -> bool {
        let n = self.particles.len();
        let mut seen = vec![false; n];
        let ids_are_names = self.particles.id.iter().all(|&id| (id as usize) < n && !std::mem::replace(&mut seen[id as usize], true));
        let mut next = 0;
        let bins_are_ranges = self.bins.iter().all(|bin| bin.start < bin.end && std::mem::replace(&mut next, bin.end) == bin.start);
        let key = |bin: &Bin| (bin.field, colour(bin.block), bin.block);
        // each block once: kernels rely on it when they work on bins side by side
        let blocks_are_different = self.bins.is_sorted_by(|a, b| key(a) < key(b));
        let blocks_are_on_the_grid = self.bins.iter().flat_map(|bin| bin.block).all(|b| (0..1 << 28).contains(&b));
        let order_is_sound = self.order.drift >= 0.0;
        let bodies = other.particles.body.iter().max();
        let numbers = [self.time, self.last_step, self.next_step, self.acceleration_age, self.pace, self.external_work];
        self.particles.fits(&other.particles)
            && self.particles.body.iter().max() <= bodies
            && numbers.iter().all(|v| v.is_finite())
            && self.last_step >= 0.0
            && (self.next_step > 0.0) == (other.next_step > 0.0)
            && self.acceleration_age >= 0.0
            && self.pace > 0.0
            && self.pace <= 1.0
            && ids_are_names
            && bins_are_ranges
            && blocks_are_different
            && blocks_are_on_the_grid
            && order_is_sound
            && (next as usize == n || self.bins.is_empty())
            && self.nodes.displacement.len() == other.nodes.displacement.len()
            && self.nodes.velocity.len() == other.nodes.velocity.len()
            && (self.nodes.acceleration.is_empty() || self.nodes.acceleration.len() == self.nodes.velocity.len())
            && self.reactions.len() == other.reactions.len()
            && self.inputs.len() == other.inputs.len()
            && self.inputs.iter().zip(&other.inputs).all(|(a, b)| a.len() == b.len())
    }
}
