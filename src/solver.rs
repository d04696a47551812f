//! The two formulations behind one face: the choice between them is made once, when a scene is built.

use crate::component::{Fallback, StepError};
use crate::model::Model;
use crate::state::State;
use crate::step::measure::Measures;
use crate::step::{Next, Stepper, Wrong, limit, worth_sharing};
use crate::total::{Total, Updated};
use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// What moves a state on.
pub(crate) enum Solver {
    /// Particles through a grid that forgets.
    Updated(Box<Stepper>),
    /// The same in implicit steps.
    Implicit(Box<Updated>),
    /// Bodies on grids of their own.
    Total(Box<Total>),
}

impl Solver {
    /// Makes the solver, and the state ready for it.
    pub(crate) fn new(model: &Model, state: &mut State) -> Self {
        if model.total {
            let mut total = Total::new(model, state);
            total.start(model, state);
            Self::Total(Box::new(total))
        } else if model.implicit.is_some() {
            Self::Implicit(Box::new(Updated::new(model)))
        } else {
            Self::Updated(Box::new(Stepper::new(model)))
        }
    }

    /// Largest stable step at time 0 \[s\]; infinite where steps are implicit.
    pub(crate) fn stable_step(&mut self, model: &Model, state: &State) -> Result<f64, StepError> {
        if model.implicit.is_some() {
            return Ok(f64::INFINITY);
        }
        match self {
            Self::Updated(_) | Self::Implicit(_) => limit::stable_step(model, state),
            Self::Total(total) => total.stable_step(model, state),
        }
    }

    /// Makes a state at time 0 ready.
    pub(crate) fn restart(&mut self, model: &Model, state: &mut State) {
        if let Self::Total(total) = self {
            total.start(model, state);
        }
        self.forget(model);
    }

    /// Forgets what belongs to another state.
    pub(crate) fn forget(&mut self, model: &Model) {
        match self {
            Self::Updated(stepper) => stepper.forget(model),
            Self::Implicit(updated) => updated.stepper.forget(model),
            Self::Total(total) => total.forget(),
        }
    }

    /// Starts to add up boundary reactions.
    pub(crate) fn begin(&mut self, model: &Model) {
        match self {
            Self::Updated(stepper) => stepper.begin(model),
            Self::Implicit(updated) => updated.begin(model),
            Self::Total(total) => total.begin(model),
        }
    }

    /// Whether loops of a step are shared between threads.
    pub(crate) fn shares(&self, state: &State) -> bool {
        match self {
            Self::Updated(_) | Self::Implicit(_) => worth_sharing(state),
            Self::Total(total) => total.shares(state),
        }
    }

    /// One step of length `dt` \[s\], and what can be done for the `next` in passing. On an error the state is spoilt; the caller holds a copy.
    pub(crate) fn advance(&mut self, model: &Model, state: &mut State, dt: f64, next: Option<Next>) -> Result<(), StepError> {
        match self {
            Self::Updated(stepper) => stepper.advance(model, state, dt, next),
            Self::Implicit(updated) => match model.implicit {
                Some(scheme) => updated.advance(model, state, scheme, dt),
                None => updated.stepper.advance(model, state, dt, next),
            },
            Self::Total(total) => total.advance(model, state, dt),
        }
    }

    /// Ends a call of `step`: sets the mean reactions since [`Self::begin`], and the particles where nodes lead them.
    pub(crate) fn end(&mut self, model: &Model, state: &mut State) {
        state.reactions.clear();
        match self {
            Self::Updated(stepper) => {
                state.reactions.extend(stepper.mean_reactions());
                stepper.tidy(model, state);
            }
            Self::Implicit(updated) => {
                state.reactions.extend(updated.mean_reactions());
                updated.stepper.tidy(model, state);
            }
            Self::Total(total) => {
                state.reactions.extend(total.mean_reactions());
                if !total.shows_late() {
                    total.show(model, state);
                }
            }
        }
    }

    /// Makes the particles of a state what the nodes make of them, where that is only done when somebody looks.
    pub(crate) fn show(&mut self, model: &Model, state: &mut State) -> Result<(), StepError> {
        if let Self::Total(total) = self { total.catch_up(model, state) } else { Ok(()) }
    }

    /// Iterations of the solver of the mass matrix, or of Newton's method, since [`Self::begin`].
    pub(crate) fn iterations(&self) -> u64 {
        match self {
            Self::Updated(stepper) => stepper.iterations,
            Self::Implicit(updated) => updated.iterations(),
            Self::Total(total) => total.iterations(),
        }
    }

    /// Where the last step fell back to a lower order.
    pub(crate) fn fallback(&self) -> Fallback {
        match self {
            Self::Updated(stepper) => stepper.fallback(),
            Self::Implicit(_) => Fallback::default(),
            Self::Total(total) => Fallback { nodes: total.alone(), ..Fallback::default() },
        }
    }

    /// Forces out of balance over those in balance, by iteration of Newton's method in the last step.
    pub(crate) fn residuals(&self) -> &[f64] {
        match self {
            Self::Updated(_) => &[],
            Self::Implicit(updated) => updated.residuals(),
            Self::Total(total) => total.residuals(),
        }
    }

    /// Measures the state, which stays as it is but for the order of its particles.
    pub(crate) fn measure(&mut self, model: &Model, state: &mut State) -> Result<Measures, StepError> {
        match self {
            Self::Updated(stepper) => stepper.measure(model, state),
            Self::Implicit(updated) => updated.stepper.measure(model, state),
            Self::Total(total) => {
                total.catch_up(model, state)?;
                Ok(total.measure(model, state))
            }
        }
    }

    /// Measures the probes of a state whose nodes are remembered; nothing else.
    pub(crate) fn probe(&self, model: &Model, state: &State) -> Measures {
        let mut measures = Measures::default();
        if let Self::Total(total) = self {
            total.probe(model, state, &mut measures);
        }
        measures
    }

    /// Place in memory by particle id.
    pub(crate) fn lookup(&mut self, state: &State) -> &[u32] {
        match self {
            Self::Updated(stepper) => stepper.lookup(state),
            Self::Implicit(updated) => updated.stepper.lookup(state),
            Self::Total(total) => total.lookup(),
        }
    }

    /// How grids of bodies of their own fit them, in words.
    pub(crate) fn grids(&self, model: &Model) -> Option<String> {
        if let Self::Total(total) = self { Some(total.grids(model)) } else { None }
    }

    /// Memory of grids and tables \[bytes\].
    pub(crate) fn bytes(&self) -> usize {
        match self {
            Self::Updated(stepper) => stepper.grid.bytes(),
            Self::Implicit(updated) => updated.stepper.grid.bytes(),
            Self::Total(total) => total.bytes(),
        }
    }

    /// Does it wrong on purpose, to show what comes of it.
    pub(crate) fn go_wrong(&mut self, wrong: Wrong) {
        if let Self::Updated(stepper) = self {
            stepper.wrong = Some(wrong);
        }
    }

    /// Force on a node of the grid of the scene, see [`Stepper::nodal_force`].
    pub(crate) fn nodal_force(&mut self, model: &Model, state: &mut State, node: [i32; 3]) -> Result<Option<f64>, StepError> {
        match self {
            Self::Updated(stepper) => stepper.nodal_force(model, state, node),
            Self::Implicit(updated) => updated.stepper.nodal_force(model, state, node),
            Self::Total(_) => Ok(None),
        }
    }
}

/// Does some work on a thread of the pool while the others stay awake: it takes long for one to wake up, and a step has a dozen loops to share.
pub(crate) fn awake<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    thread_local!(static LEADS: Cell<bool> = const { Cell::new(false) });
    /// Says that the work is done, or has panicked.
    struct Done(Arc<AtomicBool>, bool);
    impl Drop for Done {
        fn drop(&mut self) {
            self.0.store(true, Ordering::Release);
            LEADS.set(self.1);
        }
    }
    rayon::scope(|_| {
        let done = Done(Arc::default(), LEADS.replace(true));
        let is_done = done.0.clone();
        // nobody waits for those who have something else to do
        rayon::spawn_broadcast(move |_| {
            // who leads some work would keep it waiting
            while !LEADS.get() && !is_done.load(Ordering::Acquire) {
                if rayon::yield_now() != Some(rayon::Yield::Executed) {
                    std::thread::yield_now();
                }
            }
        });
        work()
    })
}
