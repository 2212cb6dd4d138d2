//! Several workers at one render: the devices of this machine, a thread each, and whoever else asks for units.

use crate::buffers::SceneBuffers;
use crate::frame::Frame;
use crate::gather::Gathering;
use crate::message;
use crate::queue::{Next, Queue};
use crate::report::Progress;
use crate::scene::{CompiledScene, Scene};
use crate::work::WorkUnit;
use crate::worker::{Outcome, Worker};
use crate::{PhotonFile, RenderError, Settings};
use caustic_device::Device;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread;
use std::time::{Duration, Instant};

/// How long the crew's main thread waits for news before it looks after progress again.
const NEWS: Duration = Duration::from_millis(50);
/// The same where others have to be asked for theirs.
const REMOTE_NEWS: Duration = Duration::from_micros(500);

/// A unit to compute, and the radius of the first pass, m.
pub type Order = (WorkUnit, f32);

/// Workers elsewhere that compute units of the same render: other processes, which have the same scene and settings.
pub trait Remote {
    /// How many there are.
    fn workers(&self) -> usize;

    /// Gives one a unit to compute; or nothing, after which it ends.
    ///
    /// # Errors
    /// If it cannot be reached.
    fn send(&mut self, worker: usize, unit: Option<Order>) -> Result<(), RenderError>;

    /// What one of them has sent, if there is anything: what [`compute_for`] gives.
    ///
    /// # Errors
    /// If it cannot be received.
    fn receive(&mut self) -> Result<Option<(usize, Vec<u8>)>, RenderError>;
}

/// What the workers of a crew share.
pub(crate) struct Shared<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) compiled: &'a CompiledScene,
    pub(crate) settings: &'a Settings,
    pub(crate) photons: Option<&'a PhotonFile>,
    pub(crate) first_radius: f32,
    pub(crate) queue: &'a Queue,
}

enum News {
    /// How much of its unit a worker has done.
    Share(usize, f64),
    /// What it came to.
    Came(usize, WorkUnit, Box<Outcome>),
    /// A worker does no more, and why if that is an error.
    Ended(usize, Result<(), RenderError>),
}

/// Computes the units of the queue on all devices and by those elsewhere. `first` is the worker of the first device.
pub(crate) fn work(
    shared: &Shared<'_>,
    first: Worker<'_>,
    devices: &[&Device],
    remote: Option<&mut dyn Remote>,
    gathering: &mut Gathering<'_>,
    progress: &mut dyn FnMut(Progress) -> bool,
) -> Result<(), RenderError> {
    thread::scope(|scope| {
        let (send, news) = mpsc::channel();
        // Nobody listens to the end of a thread any more if there was an error.
        let first_send = send.clone();
        scope.spawn(move || {
            let ended = caught(0, || run(shared.queue, first, 0, &first_send));
            first_send.send(News::Ended(0, ended))
        });
        for (number, &device) in devices.iter().enumerate().skip(1) {
            let send = send.clone();
            scope.spawn(move || {
                let ended = caught(number, || begin(shared, device, number, &send));
                send.send(News::Ended(number, ended))
            });
        }
        drop(send);
        let result = attend(shared, devices, remote, gathering, progress, &news);
        shared.queue.stop();
        result
    })
}

/// A driver that panics is a device that is lost. Nothing that the work has changed is used afterwards.
fn caught(worker: usize, work: impl FnOnce() -> Result<(), RenderError>) -> Result<(), RenderError> {
    let panicked = |_| RenderError::Elsewhere { worker, reason: "it panicked".to_string() };
    catch_unwind(AssertUnwindSafe(work)).map_err(panicked)?
}

/// A thread: puts the scene on a device and goes to work.
fn begin(shared: &Shared<'_>, device: &Device, number: usize, send: &Sender<News>) -> Result<(), RenderError> {
    let Shared { scene, compiled, settings, photons, first_radius, queue } = *shared;
    let buffers = SceneBuffers::new(device, compiled)?;
    let frame = Frame::new(device, scene, compiled, &buffers, settings, photons)?;
    run(queue, Worker::new(frame, first_radius), number, send)
}

/// Takes units for a worker until there are none.
fn run(queue: &Queue, mut worker: Worker<'_>, number: usize, send: &Sender<News>) -> Result<(), RenderError> {
    while let Some(unit) = queue.take(number) {
        let mut told = Instant::now();
        let outcome = worker.run(unit, &mut |now| {
            if now.phase == "image" && told.elapsed() > NEWS {
                told = Instant::now();
                let _ = send.send(News::Share(number, now.done as f64 / now.total.max(1) as f64));
            }
            !queue.is_idle(&unit)
        });
        match outcome {
            // Somebody else was faster, or nothing is wanted any more.
            Err(RenderError::Interrupted) => {}
            outcome => {
                let _ = send.send(News::Came(number, unit, Box::new(outcome?)));
            }
        }
    }
    Ok(())
}

/// The main thread: takes in what comes, and tells of progress.
fn attend(
    shared: &Shared<'_>,
    devices: &[&Device],
    mut remote: Option<&mut dyn Remote>,
    gathering: &mut Gathering<'_>,
    progress: &mut dyn FnMut(Progress) -> bool,
    news: &Receiver<News>,
) -> Result<(), RenderError> {
    let queue = shared.queue;
    let mut shares = vec![0.0; devices.len()];
    let mut running = devices.len();
    let mut elsewhere = Elsewhere { free: Vec::new(), busy: Vec::new(), first: devices.len() };
    elsewhere.free.extend(0..remote.as_ref().map_or(0, |remote| remote.workers()));
    let mut shown = Instant::now();
    while running > 0 || elsewhere.is_there() {
        if let Some(remote) = remote.as_deref_mut() {
            elsewhere.exchange(remote, shared, gathering)?;
        }
        match news.recv_timeout(if elsewhere.is_there() { REMOTE_NEWS } else { NEWS }) {
            Ok(News::Share(worker, share)) => shares[worker] = share,
            Ok(News::Came(worker, unit, outcome)) => {
                shares[worker] = 0.0;
                if queue.finish(worker, &unit) {
                    gathering.accept(*outcome)?;
                }
            }
            Ok(News::Ended(worker, ended)) => {
                running -= 1;
                shares[worker] = 0.0;
                if let Err(error) = ended {
                    queue.lose(worker);
                    if !error.is_of_device() || (running == 0 && !elsewhere.is_there()) {
                        return Err(error);
                    }
                    gathering.lost(&error);
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
            // All threads here have ended.
            Err(RecvTimeoutError::Disconnected) => thread::sleep(REMOTE_NEWS),
        }
        if shown.elapsed() > NEWS {
            shown = Instant::now();
            if !progress(gathering.progress(shares.iter().sum())) {
                gathering.interrupt();
            }
        }
        match gathering.stopped_by {
            None => {}
            Some("time") => queue.close(),
            Some(_) => queue.stop(),
        }
    }
    Ok(())
}

/// Which workers elsewhere have nothing to do, and which have what.
struct Elsewhere {
    free: Vec<usize>,
    busy: Vec<(usize, WorkUnit)>,
    /// Number of the first of them in the queue.
    first: usize,
}

impl Elsewhere {
    fn is_there(&self) -> bool {
        !self.free.is_empty() || !self.busy.is_empty()
    }

    /// Hands out units and takes in what has come.
    fn exchange(
        &mut self,
        remote: &mut dyn Remote,
        shared: &Shared<'_>,
        gathering: &mut Gathering<'_>,
    ) -> Result<(), RenderError> {
        let queue = shared.queue;
        while let Some((worker, bytes)) = remote.receive()? {
            let Some(at) = self.busy.iter().position(|(busy, _)| *busy == worker) else { continue };
            let (_, unit) = self.busy.swap_remove(at);
            match message::decode(&bytes) {
                Ok(outcome) => {
                    self.free.push(worker);
                    if queue.finish(self.first + worker, &unit) {
                        gathering.accept(outcome)?;
                    }
                }
                Err(reason) => {
                    queue.lose(self.first + worker);
                    remote.send(worker, None)?;
                    gathering.lost(&RenderError::Elsewhere { worker, reason });
                }
            }
        }
        for worker in std::mem::take(&mut self.free) {
            match queue.try_take(self.first + worker) {
                Next::Unit(unit) => {
                    remote.send(worker, Some((unit, shared.first_radius)))?;
                    self.busy.push((worker, unit));
                }
                Next::Wait => self.free.push(worker),
                Next::Nothing => remote.send(worker, None)?,
            }
        }
        Ok(())
    }
}

/// Computes units for a render that another process gathers: `exchange` hands over what the last one came to and gets the next.
///
/// # Errors
/// Those of `exchange`. What goes wrong here is handed over instead, and the other process says when to end.
pub fn compute_for(
    scene: &Scene,
    settings: &Settings,
    device: &Device,
    photons: Option<&PhotonFile>,
    exchange: &mut dyn FnMut(Option<Vec<u8>>) -> Result<Option<Order>, RenderError>,
) -> Result<(), RenderError> {
    let compiled = scene.compile();
    let Some((mut unit, first_radius)) = exchange(None)? else { return Ok(()) };
    let prepared = SceneBuffers::new(device, &compiled);
    let frame = prepared.as_ref().map(|buffers| Frame::new(device, scene, &compiled, buffers, settings, photons));
    let mut worker = match frame {
        Ok(Ok(frame)) => Ok(Worker::new(frame, first_radius)),
        Ok(Err(error)) => Err(error.to_string()),
        Err(error) => Err(error.to_string()),
    };
    loop {
        let outcome = match &mut worker {
            Ok(worker) => worker.run(unit, &mut |_| true).map_err(|error| error.to_string()),
            Err(reason) => Err(reason.clone()),
        };
        match exchange(Some(message::encode(&outcome)))? {
            Some((next, _)) => unit = next,
            None => return Ok(()),
        }
    }
}
