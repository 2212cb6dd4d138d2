//! Processes that `mpirun` started together: one of them, the root, gathers what all compute.

use crate::Failure;

/// What the launchers of MPI (Open MPI, MPICH and Slurm) say of how many processes they have started.
const SIZES: [&str; 2] = ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE"];

/// How many processes were started together, as far as a launcher says so.
fn started() -> Option<usize> {
    SIZES.iter().find_map(|name| std::env::var(name).ok()?.parse().ok())
}

#[cfg(feature = "mpi")]
pub use with_mpi::Ranks;
#[cfg(not(feature = "mpi"))]
pub use without_mpi::Ranks;

#[cfg(feature = "mpi")]
mod with_mpi {
    use super::{Failure, started};
    use caustic_device::Device;
    use caustic_renderer::scene::Scene;
    use caustic_renderer::{PhotonFile, Remote, RenderError, Settings, WorkUnit, compute_for};
    use mpi::Threading;
    use mpi::environment::Universe;
    use mpi::topology::SimpleCommunicator;
    use mpi::traits::{Communicator, CommunicatorCollectives, Destination, Source};
    use std::thread::sleep;
    use std::time::Duration;

    /// Longest message: MPI counts bytes in an `i32`.
    const MOST: usize = 1 << 30;
    /// How often a process without work looks for some. Open MPI's own waiting would keep a core busy.
    const LOOK: Duration = Duration::from_micros(500);

    /// This process among the others.
    pub struct Ranks {
        world: SimpleCommunicator,
        /// Ends MPI when it is dropped.
        _universe: Universe,
    }

    impl Ranks {
        /// Joins the others; nothing if there are none.
        pub fn join() -> Result<Option<Self>, Failure> {
            if started().is_none_or(|size| size < 2) {
                return Ok(None);
            }
            let (universe, _) = mpi::initialize_with_threading(Threading::Funneled)
                .ok_or_else(|| Failure::machine("MPI could not be started; start the processes with mpirun or srun"))?;
            Ok(Some(Self { world: universe.world(), _universe: universe }))
        }

        pub fn is_root(&self) -> bool {
            self.world.rank() == 0
        }

        /// Which of `count` devices of this host is this process's: each takes the next.
        pub fn device(&self, count: usize) -> usize {
            let names = ["OMPI_COMM_WORLD_LOCAL_RANK", "MPI_LOCALRANKID", "SLURM_LOCALID"];
            let local = names.iter().find_map(|name| std::env::var(name).ok()?.parse::<usize>().ok());
            local.unwrap_or(self.world.rank() as usize) % count
        }

        /// Checks that all are ready to compute the same. `ready` is what this one would compute, if nothing is wrong.
        pub fn agree(&self, ready: Option<[u8; 32]>) -> Result<(), Failure> {
            let mut mine = [0; 33];
            if let Some(digest) = ready {
                mine[0] = 1;
                mine[1..].copy_from_slice(&digest);
            }
            let mut all = vec![0u8; 33 * self.world.size() as usize];
            self.world.all_gather_into(&mine[..], &mut all[..]);
            let ranks: Vec<&[u8]> = all.chunks(33).collect();
            if let Some(rank) = ranks.iter().position(|rank| rank[0] == 0) {
                // That one says why.
                return Err(Failure::input(format!("rank {rank} could not begin, and nothing was rendered")));
            }
            match ranks.iter().position(|rank| rank != &ranks[0]) {
                Some(rank) => Err(Failure::input(format!(
                    "rank {rank} has another scene, version or precision than rank 0; start all with the same files and arguments"
                ))),
                None => Ok(()),
            }
        }

        /// Computes units for the root until it has enough.
        pub fn help(
            &self,
            scene: &Scene,
            settings: &Settings,
            device: &Device,
            photons: Option<&PhotonFile>,
        ) -> Result<(), RenderError> {
            let root = self.world.process_at_rank(0);
            compute_for(scene, settings, device, photons, &mut |bytes| {
                if let Some(bytes) = bytes {
                    root.send(&(bytes.len() as u64));
                    bytes.chunks(MOST).for_each(|chunk| root.send(chunk));
                }
                while root.immediate_probe().is_none() {
                    sleep(LOOK);
                }
                let (order, _) = root.receive_vec::<u32>();
                Ok(match order[..] {
                    [pass, first_pixel, pixels, radius] => {
                        Some((WorkUnit { pass, first_pixel, pixels }, f32::from_bits(radius)))
                    }
                    _ => None,
                })
            })
        }

        /// Ends all processes, since this one cannot go on.
        pub fn abort(&self, code: u8) -> ! {
            self.world.abort(code.into())
        }
    }

    impl Remote for Ranks {
        fn workers(&self) -> usize {
            self.world.size() as usize - 1
        }

        fn send(&mut self, worker: usize, unit: Option<(WorkUnit, f32)>) -> Result<(), RenderError> {
            let order = match unit {
                Some((WorkUnit { pass, first_pixel, pixels }, radius)) => {
                    vec![pass, first_pixel, pixels, radius.to_bits()]
                }
                None => Vec::new(),
            };
            self.world.process_at_rank(worker as i32 + 1).send(&order[..]);
            Ok(())
        }

        fn receive(&mut self) -> Result<Option<(usize, Vec<u8>)>, RenderError> {
            let Some(status) = self.world.any_process().immediate_probe() else { return Ok(None) };
            let rank = self.world.process_at_rank(status.source_rank());
            let (length, _) = rank.receive::<u64>();
            let mut bytes = vec![0; length as usize];
            for chunk in bytes.chunks_mut(MOST) {
                rank.receive_into(chunk);
            }
            Ok(Some((status.source_rank() as usize - 1, bytes)))
        }
    }
}

#[cfg(not(feature = "mpi"))]
mod without_mpi {
    use super::{Failure, started};
    use caustic_device::Device;
    use caustic_renderer::scene::Scene;
    use caustic_renderer::{PhotonFile, Remote, RenderError, Settings, WorkUnit};

    /// There are no others in this program.
    pub enum Ranks {}

    impl Ranks {
        /// Refuses to be one of several: all would render everything.
        pub fn join() -> Result<Option<Self>, Failure> {
            match started() {
                Some(size) if size > 1 => Err(Failure::input(format!(
                    "{size} processes were started together, but this program was built without MPI; build it with `--features mpi` or use --part"
                ))),
                _ => Ok(None),
            }
        }

        pub fn is_root(&self) -> bool {
            match *self {}
        }

        pub fn device(&self, _count: usize) -> usize {
            match *self {}
        }

        pub fn agree(&self, _ready: Option<[u8; 32]>) -> Result<(), Failure> {
            match *self {}
        }

        pub fn help(&self, _: &Scene, _: &Settings, _: &Device, _: Option<&PhotonFile>) -> Result<(), RenderError> {
            match *self {}
        }

        pub fn abort(&self, _code: u8) -> ! {
            match *self {}
        }
    }

    impl Remote for Ranks {
        fn workers(&self) -> usize {
            match *self {}
        }

        fn send(&mut self, _worker: usize, _unit: Option<(WorkUnit, f32)>) -> Result<(), RenderError> {
            match *self {}
        }

        fn receive(&mut self) -> Result<Option<(usize, Vec<u8>)>, RenderError> {
            match *self {}
        }
    }
}
