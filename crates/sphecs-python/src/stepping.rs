//! Simulation that a program advances step by step.
//!
//! One call works on a simulation at a time. A second one, from another thread or from a force
//! while the flow is advanced, is refused: waiting for the first could last for ever, because a
//! force needs the interpreter that the waiting thread holds.

use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::{Duration, Instant};

use glam::DVec3;
use numpy::{PyArray1, PyReadonlyArray2};
use pyo3::types::{PyDict, PyDictMethods};
use pyo3::{Bound, Py, PyAny, PyResult, PyTraverseError, PyVisit, Python, pyclass, pymethods};

use crate::body_motion::body_entry;
use crate::callable::{CallableForces, Failure, Functions};
use crate::exceptions::{build_error, output_error, run_error, stop_error};
use crate::guard::detached;
use crate::scene_input::SceneInput;
use crate::snapshot::{arrays_of, vectors};
use sphecs::{Clock, Simulation as Flow, Stop};
use sphecs_run::threads::Threads;
use sphecs_run::{environment, memory};

/// Wall time between two looks for Ctrl-C. A step that takes longer is not cut.
const LOOK: Duration = Duration::from_millis(50);

/// Simulation of a scene on threads of its own.
#[pyclass(frozen, module = "sphecs._sphecs")]
pub(crate) struct Simulation {
    state: Mutex<State>,
    /// Clock of the last step, which other threads may read during a step.
    clock: Mutex<Clock>,
    functions: Functions,
    failure: Failure,
}

struct State {
    flow: Flow,
    threads: Threads,
    /// Reason for which the flow cannot be advanced any more.
    ended: Option<String>,
}

/// Reason to return from a series of steps.
enum Pause {
    Done,
    Look,
    Stopped(Stop),
    Force,
}

impl State {
    /// Advances until the goal is reached, the flow stops or it is time to look for signals.
    fn advance(&mut self, failure: &Failure, clock: &Mutex<Clock>, until: Goal) -> Pause {
        let Self { flow, threads, .. } = self;
        let started = Instant::now();
        threads.run(|| {
            while !until.is_reached(&flow.clock()) {
                let stepped = flow.step();
                *clock.lock().unwrap_or_else(PoisonError::into_inner) = flow.clock();
                // Its exception explains a stop of the same step.
                if failure.is_set() {
                    return Pause::Force;
                }
                if let Err(stop) = stepped {
                    return Pause::Stopped(stop);
                }
                if started.elapsed() > LOOK {
                    return Pause::Look;
                }
            }
            Pause::Done
        })
    }
}

/// End of a series of steps.
#[derive(Clone, Copy)]
enum Goal {
    Step(u64),
    Time(f64),
}

impl Goal {
    fn is_reached(self, clock: &Clock) -> bool {
        match self {
            Self::Step(step) => clock.step >= step,
            Self::Time(time) => clock.time >= time,
        }
    }
}

impl Simulation {
    fn lock(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, State>> {
        match self.state.try_lock() {
            Ok(state) => Ok(state),
            Err(TryLockError::WouldBlock) => Err(run_error(
                py,
                "busy",
                "the simulation is in use by another call: wait for its end, and use no simulation inside its own forces"
                    .to_owned(),
            )),
            // No lock is held during a panic: `detached` catches it first.
            Err(TryLockError::Poisoned(state)) => Ok(state.into_inner()),
        }
    }

    fn advance(&self, py: Python<'_>, until: impl FnOnce(&Clock) -> Goal) -> PyResult<()> {
        let mut state = self.lock(py)?;
        if let Some(reason) = &state.ended {
            let message = format!("the simulation has ended: {reason}; build it again");
            return Err(run_error(py, "ended", message));
        }
        let state = &mut *state;
        let until = until(&state.flow.clock());
        loop {
            let (failure, clock) = (&self.failure, &self.clock);
            let pause = detached(py, || state.advance(failure, clock, until));
            match pause {
                Ok(Pause::Done) => return py.check_signals(),
                Ok(Pause::Look) => py.check_signals()?,
                Ok(Pause::Stopped(stop)) => {
                    state.ended = Some(stop.to_string());
                    return Err(stop_error(py, stop));
                }
                Ok(Pause::Force) => {
                    state.ended = Some("a force raised an exception within a step".to_owned());
                    return Err(self.failure.take().unwrap_or_else(|| {
                        run_error(py, "internal", "a force failed without an exception".to_owned())
                    }));
                }
                Err(panic) => {
                    state.ended = Some("of an internal error".to_owned());
                    return Err(panic);
                }
            }
        }
    }
}

#[pymethods]
impl Simulation {
    #[new]
    fn new(
        py: Python<'_>,
        scene: SceneInput,
        forces: Vec<Py<PyAny>>,
        threads: Option<usize>,
    ) -> PyResult<Self> {
        environment::check().map_err(|error| output_error(py, &error))?;
        let scene = scene.load(py, memory::available())?;
        let threads = Threads::start(threads)
            .map_err(|error| run_error(py, "threads", format!("cannot start the threads: {error}")))?;
        let failure = Failure::default();
        let functions = Functions::new(forces);
        let plugin = CallableForces {
            functions: functions.clone(),
            dimensions: scene.dimensions,
            failure: failure.clone(),
        };
        let flow = detached(py, || threads.run(|| Flow::builder(scene).plugin(plugin).build()))?;
        let flow = flow.map_err(|error| build_error(py, &error))?;
        let clock = Mutex::new(flow.clock());
        Ok(Self { state: Mutex::new(State { flow, threads, ended: None }), clock, functions, failure })
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.functions.traverse(&visit)
    }

    fn __clear__(&self) {
        self.functions.clear();
    }

    /// Advances by a number of steps.
    fn step(&self, py: Python<'_>, count: u64) -> PyResult<()> {
        self.advance(py, |clock| Goal::Step(clock.step.saturating_add(count)))
    }

    /// Advances until the first time at or after `time`, s.
    fn run_until(&self, py: Python<'_>, time: f64) -> PyResult<()> {
        self.advance(py, |_| Goal::Time(time))
    }

    /// Returns time, s, number of steps and size of the last step, s.
    fn clock(&self) -> (f64, u64, f64) {
        let Clock { time, step, time_step } = *self.clock.lock().unwrap_or_else(PoisonError::into_inner);
        (time, step, time_step)
    }

    /// Returns name, number of dimensions, lengths, m, and end, s, of the scene.
    fn scene<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let state = self.lock(py)?;
        let scene = state.flow.scene();
        let entry = PyDict::new(py);
        entry.set_item("name", &scene.name)?;
        entry.set_item("title", &scene.title)?;
        entry.set_item("dimensions", scene.dimensions)?;
        entry.set_item("spacing", scene.spacing)?;
        entry.set_item("smoothing_length", scene.discretisation.smoothing_length)?;
        entry.set_item("density", scene.fluid.density)?;
        entry.set_item("sound_speed", scene.fluid.sound_speed)?;
        entry.set_item("end", scene.time.end)?;
        Ok(entry)
    }

    /// Returns the arrays of the particles by their names.
    fn snapshot<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let mut state = self.lock(py)?;
        let State { flow, threads, .. } = &mut *state;
        let dimensions = flow.scene().dimensions;
        let table = detached(py, || threads.run(|| flow.particles()))?;
        arrays_of(py, table, dimensions)
    }

    /// Returns the forces on the bodies at the beginning of the last step by their names.
    fn body_forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let state = self.lock(py)?;
        let (scene, row) = (state.flow.scene(), state.flow.body_forces());
        let bodies = PyDict::new(py);
        for ((body, sum), motion) in scene.bodies.iter().zip(&row.forces).zip(&row.motions) {
            bodies.set_item(&body.name, body_entry(py, row.time, sum, motion.as_ref(), scene.dimensions)?)?;
        }
        Ok(bodies)
    }

    /// Returns velocity, pressure and density of the fluid at points; NaN without fluid nearby.
    fn sample<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let points: Vec<DVec3> = points
            .as_array()
            .rows()
            .into_iter()
            .map(|row| {
                let mut point = DVec3::ZERO;
                for (axis, &value) in row.iter().take(3).enumerate() {
                    point[axis] = value;
                }
                point
            })
            .collect();
        let mut state = self.lock(py)?;
        let State { flow, threads, .. } = &mut *state;
        let dimensions = flow.scene().dimensions;
        let samples = detached(py, || threads.run(|| flow.sample(&points)))?;
        let velocity: Vec<DVec3> =
            samples.iter().map(|sample| sample.map_or(DVec3::NAN, |sample| sample.velocity)).collect();
        let scalar = |of: fn(sphecs::Sample) -> f64| {
            PyArray1::from_iter(py, samples.iter().map(|sample| sample.map_or(f64::NAN, of)))
        };
        let fields = PyDict::new(py);
        fields.set_item("velocity", vectors(py, &velocity, 0..dimensions)?)?;
        fields.set_item("pressure", scalar(|sample| sample.pressure))?;
        fields.set_item("density", scalar(|sample| sample.density))?;
        Ok(fields)
    }

    /// Returns the notes on outlets that do not behave as intended.
    fn notes(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        Ok(self.lock(py)?.flow.notes().to_vec())
    }
}
