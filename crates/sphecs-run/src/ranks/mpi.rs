//! Ranks that are processes of an MPI job.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use mpi::Threading;
use mpi::collective::CommunicatorCollectives;
use mpi::datatype::PartitionMut;
use mpi::environment::Universe;
use mpi::point_to_point::{Destination, Source};
use mpi::request::{Request, Scope};
use mpi::topology::{Communicator, SimpleCommunicator};
use serde::{Deserialize, Serialize};

use super::RankSource;
use super::launcher::Launched;
use crate::console::Console;
use crate::error::RunError;
use crate::signals::Signals;
use crate::threads::on_threads;
use sphecs_core::math::column::Columns;
use sphecs_core::math::lanes::InstructionSet;
use sphecs_core::pass::ranks::{Ranks, Transport};
use sphecs_engine::saved_state::{decode_record, encode_record};
use sphecs_engine::simulation::Simulation;
use sphecs_output::checkpoint::container;
use sphecs_output::checkpoint::{Checkpoint, Facts};
use sphecs_scene::meshes::MeshFile;
use sphecs_scene::model::Scene;

/// Returns the ranks of an MPI job; None in a process that has followed rank 0 to its end, with a
/// number of threads.
pub(super) fn of_job(_: Launched, threads: Option<usize>) -> Result<Option<RankSource>, RunError> {
    let session = Session::start();
    let session = session.ok_or_else(|| RunError::Ranks("MPI cannot be initialised".to_owned()))?;
    let lanes = session.check_lanes();
    if session.rank() == 0 {
        // The others end with this one.
        lanes.map_err(RunError::Ranks)?;
        return Ok(Some(RankSource::Mpi(Arc::new(session))));
    }
    // Rank 0 obeys the signals, which the launcher sends to all.
    let _signals = Signals::listen().map_err(RunError::Signals)?;
    let followed = on_threads(threads, || session.follow()).map_err(|refused| refused.to_string());
    if let Err(what) = followed.flatten() {
        // The others would wait for this rank for ever.
        Console::Normal.warn(&format!("rank {}: {what}", session.rank()));
        SimpleCommunicator::world().abort(BAD_INPUT);
    }
    Ok(None)
}

/// Exit code of all ranks when one cannot follow.
const BAD_INPUT: i32 = 2;

/// This process as a rank of an MPI job; dropping it ends MPI.
pub struct Session {
    _universe: Universe,
    rank: usize,
    size: usize,
    /// True once the other ranks follow a simulation.
    leads: AtomicBool,
}

/// Scene of a run.
#[derive(Debug, Serialize, Deserialize)]
struct SceneFiles {
    name: String,
    text: String,
    tables: Vec<(String, String)>,
    meshes: Vec<(String, Vec<u8>)>,
}

impl fmt::Debug for Session {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "rank {} of {}", self.rank, self.size)
    }
}

impl Session {
    /// Initialises MPI; None if it is initialised already.
    pub fn start() -> Option<Self> {
        // Steps run on a thread of the pool, one at a time.
        let (universe, _) = mpi::initialize_with_threading(Threading::Serialized)?;
        let world = universe.world();
        let (rank, size) = (world.rank() as usize, world.size() as usize);
        Some(Self { _universe: universe, rank, size, leads: AtomicBool::new(false) })
    }

    /// Returns the number of this rank, from 0.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Returns the number of ranks.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Compares the instruction sets of all ranks: unlike ones would round differently.
    fn check_lanes(&self) -> Result<(), String> {
        let mut own = [0; NAME];
        let name = InstructionSet::best().name();
        own[..name.len()].copy_from_slice(name.as_bytes());
        let mut all = Vec::new();
        self.world().all_gather(&own, &vec![NAME; self.size], &mut all);
        let mut others = (0..).zip(all.chunks(NAME));
        let Some((rank, other)) = others.find(|(_, other)| *other != own) else { return Ok(()) };
        let other = String::from_utf8_lossy(other);
        Err(format!(
            "rank {} computes on {name} lanes, rank {rank} on {}, which would round differently: set \
             `SPHECS_LANES` for all ranks to a set that all machines have",
            self.rank,
            other.trim_end_matches('\0'),
        ))
    }

    /// Sends scene and state of a simulation to the other ranks, which follow it from there on.
    pub(super) fn lead(&self, simulation: &mut Simulation) {
        let scene = simulation.scene();
        let (name, text, tables) = (scene.name.clone(), scene.text.clone(), scene.tables.clone());
        let meshes = scene.meshes.iter().map(|mesh| (mesh.path.clone(), mesh.bytes.to_vec())).collect();
        let files = encode_record(&SceneFiles { name, text, tables, meshes });
        let ranks = self.ranks();
        ranks.from_first(&(files.len() as u64).to_le_bytes(), LENGTH);
        ranks.from_first(&files, files.len());
        self.leads.store(true, Ordering::Relaxed);
        let division = simulation.divide(self.size);
        for rank in 1..self.size {
            let checkpoint = Checkpoint { facts: Facts::default(), state: simulation.part(&division, rank) };
            let mut part = Vec::new();
            // Writing to memory does not fail.
            container::write(&checkpoint, &mut part).expect("a state in memory");
            ranks.from_first(&(part.len() as u64).to_le_bytes(), LENGTH);
            let mut outgoing = vec![Vec::new(); self.size];
            outgoing[rank] = part;
            self.world().exchange(&outgoing, &mut vec![Vec::new(); self.size]);
        }
        simulation.lead(ranks, division);
    }

    /// Returns the part of the state with which this rank begins.
    fn receive_part(&self, ranks: &Ranks) -> Result<Columns, String> {
        let mut part = Vec::new();
        for rank in 1..self.size {
            let length = length_from(ranks)?;
            if rank == self.rank {
                let mut incoming = vec![Vec::new(); self.size];
                incoming[0] = vec![0; length];
                self.world().exchange(&vec![Vec::new(); self.size], &mut incoming);
                part = incoming.swap_remove(0);
            }
        }
        container::read(&part).map(|part| part.state).map_err(|rejection| rejection.to_string())
    }

    /// Follows the simulation of rank 0 to its end, on the thread pool of the caller.
    ///
    /// # Errors
    /// The fault of the scene or the state that rank 0 sent: it runs another program.
    pub fn follow(&self) -> Result<(), String> {
        let ranks = self.ranks();
        let length = length_from(&ranks)?;
        if length == 0 {
            return Ok(());
        }
        let files = ranks.from_first(&[], length);
        let part = self.receive_part(&ranks)?;
        let simulation = Simulation::builder(read_scene(&files)?).part(part).build();
        simulation.map_err(|error| error.to_string())?.follow(ranks);
        Ok(())
    }

    fn ranks(&self) -> Ranks {
        Ranks::new(self.world())
    }

    fn world(&self) -> World {
        World { rank: self.rank, size: self.size, counts: Mutex::default() }
    }
}

/// Bytes of the name of an instruction set in a message.
const NAME: usize = 16;

/// Bytes of the length of what rank 0 sends.
const LENGTH: usize = size_of::<u64>();

/// Returns the length of what rank 0 sends next, bytes.
fn length_from(ranks: &Ranks) -> Result<usize, String> {
    let length = ranks.from_first(&[], LENGTH).try_into();
    let length: [u8; LENGTH] = length.map_err(|_| "rank 0 sent no length".to_owned())?;
    Ok(u64::from_le_bytes(length) as usize)
}

/// Returns the scene whose files rank 0 sent.
fn read_scene(bytes: &[u8]) -> Result<Scene, String> {
    let SceneFiles { name, text, tables, meshes } = decode_record(bytes)?;
    let mesh = |(path, bytes): (String, Vec<u8>)| MeshFile { path, bytes: bytes.into() };
    let meshes: Vec<_> = meshes.into_iter().map(mesh).collect();
    let scene = Scene::from_text(&name, &text).tables(tables).meshes(meshes).load();
    scene.map_err(|faults| faults.to_string())
}

impl Drop for Session {
    fn drop(&mut self) {
        // The others still wait for a beginning if the run ended before its first step.
        if self.rank == 0 && !self.leads.load(Ordering::Relaxed) && !std::thread::panicking() {
            self.ranks().from_first(&0_u64.to_le_bytes(), LENGTH);
        }
    }
}

/// All processes of the job.
#[derive(Debug)]
struct World {
    rank: usize,
    size: usize,
    /// Lengths and places of the messages, as MPI takes them.
    counts: Mutex<(Vec<i32>, Vec<i32>)>,
}

/// Message on its way.
enum Pending<'a, S: Scope<'a>> {
    Receive(Request<'a, [u8], S>),
    Send(Request<'a, [u8], S>),
}

impl<'a, S: Scope<'a>> Pending<'a, S> {
    fn wait(self) {
        match self {
            Self::Receive(request) | Self::Send(request) => drop(request.wait()),
        }
    }
}

/// Largest part of a message that goes at once: MPI counts bytes in 32 bits.
const LARGEST: usize = 1 << 30;

impl Transport for World {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.size
    }

    fn all_gather(&self, own: &[u8], lengths: &[usize], all: &mut Vec<u8>) {
        let world = SimpleCommunicator::world();
        let total = lengths.iter().sum();
        all.resize(total, 0);
        if total <= LARGEST {
            let mut counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner);
            let (counts, places) = &mut *counts;
            counts.clear();
            places.clear();
            let mut place = 0;
            for &length in lengths {
                counts.push(length as i32);
                places.push(place);
                place += length as i32;
            }
            let mut all = PartitionMut::new(&mut all[..], &counts[..], &places[..]);
            world.all_gather_varcount_into(own, &mut all);
            return;
        }
        let mut rest = &mut all[..];
        for (rank, &length) in lengths.iter().enumerate() {
            let (message, others) = rest.split_at_mut(length);
            rest = others;
            if rank == self.rank {
                message.copy_from_slice(own);
            }
            for part in message.chunks_mut(LARGEST) {
                mpi::collective::Root::broadcast_into(&world.process_at_rank(rank as i32), part);
            }
        }
    }

    fn exchange_during(&self, outgoing: &[Vec<u8>], incoming: &mut [Vec<u8>], work: &mut dyn FnMut()) {
        let world = SimpleCommunicator::world();
        mpi::request::scope(|scope| {
            let mut requests = Vec::new();
            for (rank, message) in incoming.iter_mut().enumerate() {
                for part in message.chunks_mut(LARGEST) {
                    let from = world.process_at_rank(rank as i32);
                    requests.push(Pending::Receive(from.immediate_receive_into(scope, part)));
                }
            }
            for (rank, message) in outgoing.iter().enumerate() {
                for part in message.chunks(LARGEST) {
                    let to = world.process_at_rank(rank as i32);
                    requests.push(Pending::Send(to.immediate_send(scope, part)));
                }
            }
            work();
            requests.into_iter().for_each(Pending::wait);
        });
    }

    fn exchange_numbers(&self, outgoing: &[u64]) -> Vec<u64> {
        let mut incoming = vec![0; outgoing.len()];
        SimpleCommunicator::world().all_to_all_into(outgoing, &mut incoming[..]);
        incoming[self.rank] = 0;
        incoming
    }

    fn abandon(&self) {
        SimpleCommunicator::world().abort(1);
    }
}
