//! A render that several share: devices of one machine, one that is lost midway, and workers elsewhere. All give the bits of one.

use caustic_device::{Device, Error, Observed, Observer};
use caustic_renderer::output::LayerKind;
use caustic_renderer::{
    Given, Integrator, Part, Progress, Remote, RenderError, Rendered, Settings, Stop, WorkUnit, compute_for,
    render_across, render_on,
};
use caustic_tests::renders::*;
use caustic_tests::{assert_same_words, gpu};
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use std::sync::mpsc::{self, Receiver, Sender};

/// A CPU that is lost when it is to run a stage for the n-th time, or works slowly.
struct Faulty {
    stages: AtomicU32,
    lost_at: u32,
    pause: std::time::Duration,
}

impl Observer for Faulty {
    fn begin(&self, stage: &str) -> Result<(), Error> {
        std::thread::sleep(self.pause);
        if self.stages.fetch_add(1, Relaxed) < self.lost_at {
            return Ok(());
        }
        let lost = |text: &str| text.to_string();
        Err(Error::DeviceLost { device: lost("the faulty one"), stage: lost(stage), reason: lost("it was unplugged") })
    }

    fn observe(&self, _stage: &Observed<'_>) {}
}

/// A CPU whose driver panics.
struct Panics;

impl Observer for Panics {
    fn observe(&self, _stage: &Observed<'_>) {
        panic!("a planted panic");
    }
}

fn faulty(lost_at: u32, pause_ms: u64) -> Device {
    let pause = std::time::Duration::from_millis(pause_ms);
    Device::observed(Arc::new(Faulty { stages: AtomicU32::new(0), lost_at, pause }))
}

fn progressive(passes: u32) -> Settings {
    let stop = Stop { passes: Some(passes), ..Stop::default() };
    Settings { integrator: Integrator::Progressive, stop, ..small(&load("cornell")) }
}

fn across(settings: &Settings, devices: &[&Device]) -> Result<Rendered, RenderError> {
    render_across(&load("cornell"), settings, devices, Given::default(), &mut |_| true, &mut |_| Ok(()))
}

fn same(name: &str, a: &Rendered, b: &Rendered) {
    assert_same_words(name, floats(&a.image), floats(&b.image));
    for (a, b) in a.layers.iter().zip(&b.layers) {
        assert_same_words(&format!("{name}, {}", a.kind.name()), &a.values, &b.values);
    }
    assert_eq!(a.state, b.state, "{name}");
    let counts = |r: &Rendered| (r.report.passes, r.report.photons_emitted, r.report.camera_rays, r.report.noise);
    assert_eq!(counts(a), counts(b), "{name}");
}

#[test]
fn several_devices_make_the_picture_of_one() {
    let (one, two) = (Device::cpu(), Device::cpu());
    let layers = vec![LayerKind::Direct, LayerKind::Normal, LayerKind::Variance];
    // Passes enough for all, tiles of one pass, and passes that a number of photons or an error ends: whoever is ahead, not one more.
    let stopped = |stop: Stop| Settings { stop: Stop { passes: Some(500), ..stop }, ..progressive(1) };
    for (name, settings) in [
        ("passes", Settings { layers: layers.clone(), ..progressive(11) }),
        ("tiles", Settings { layers: vec![LayerKind::Direct], integrator: Integrator::Photon, ..progressive(1) }),
        ("photons", stopped(Stop { photons: Some(30_000), ..Stop::default() })),
        ("error", stopped(Stop { error: Some(0.1), ..Stop::default() })),
    ] {
        let expected = across(&settings, &[&one]).unwrap();
        same(name, &expected, &across(&settings, &[&one, &two]).unwrap());
        println!("{name}: {} passes, ended by {}", expected.report.passes, expected.report.stopped_by);
    }
    let Some(gpu) = gpu() else { return };
    let settings = Settings { layers, ..progressive(6) };
    same("CPU and GPU", &across(&settings, &[&one]).unwrap(), &across(&settings, &[&one, gpu]).unwrap());
}

#[test]
fn a_device_that_is_lost_leaves_its_units_to_the_others() {
    let cpu = Device::cpu();
    let settings = progressive(8);
    let expected = across(&settings, &[&cpu]).unwrap();
    for lost_at in [0, 40] {
        for tiles in [false, true] {
            let settings =
                if tiles { Settings { integrator: Integrator::Photon, ..progressive(1) } } else { settings.clone() };
            let expected = if tiles { &across(&settings, &[&cpu]).unwrap() } else { &expected };
            // The one that is not lost is slower, so that there is work left to lose.
            let rendered = across(&settings, &[&faulty(lost_at, 0), &faulty(u32::MAX, 1)]).unwrap();
            same(&format!("lost at stage {lost_at}"), expected, &rendered);
            let notes = rendered.report.notes.join("\n");
            assert!(notes.contains("given up") && notes.contains("the faulty one was lost"), "{notes}");
        }
    }
    // A driver that panics is lost like one that says so.
    let panics = Device::observed(Arc::new(Panics));
    let rendered = across(&settings, &[&panics, &faulty(u32::MAX, 1)]).unwrap();
    same("panicked", &expected, &rendered);
    assert!(rendered.report.notes.iter().any(|note| note.contains("panicked")), "{:?}", rendered.report.notes);
    // Nobody is left.
    let error = across(&settings, &[&faulty(60, 0), &faulty(60, 0)]).err().expect("an error").to_string();
    assert!(error.contains("the faulty one was lost"), "{error}");
    let error = across(&settings, &[&faulty(60, 0)]).err().expect("an error").to_string();
    assert!(error.contains("the faulty one was lost"), "{error}");
}

#[test]
fn a_slow_device_does_not_keep_the_others_waiting() {
    let settings = progressive(6);
    let (cpu, slow) = (Device::cpu(), faulty(u32::MAX, 100));
    let expected = across(&settings, &[&cpu]).unwrap();
    let begun = std::time::Instant::now();
    same("a slow one", &expected, &across(&settings, &[&slow, &cpu]).unwrap());
    // A pass has some 60 stages, so that the slow one's first alone would take it 6 s.
    println!("{:.2} s with a device that takes 0.1 s more for a stage", begun.elapsed().as_secs_f64());
    assert!(begun.elapsed().as_secs_f64() < 5.0);
}

#[test]
fn an_error_of_the_checkpoint_ends_all() {
    let (one, two) = (Device::cpu(), Device::cpu());
    let failing = &mut |_: &_| Err(RenderError::AfterPass("the disk is full".to_string()));
    let scene = load("cornell");
    let result = render_across(&scene, &progressive(50), &[&one, &two], Given::default(), &mut |_| true, failing);
    assert!(matches!(result, Err(RenderError::AfterPass(_))));
}

#[test]
fn several_devices_can_be_interrupted_and_go_on() {
    let (one, two) = (Device::cpu(), Device::cpu());
    let scene = load("cornell");
    let kept = std::cell::RefCell::new(None);
    let settings = progressive(400);
    let stopped = render_across(
        &scene,
        &settings,
        &[&one, &two],
        Given::default(),
        &mut |_: Progress| kept.borrow().is_none(),
        &mut |state| {
            *kept.borrow_mut() = Some(state.clone());
            Ok(())
        },
    );
    let stopped = stopped.unwrap();
    assert_eq!((stopped.report.complete, stopped.report.stopped_by), (false, "interrupted"));
    let done = stopped.report.passes;
    assert!(done < 400);
    let more = progressive(done + 3);
    let given = Given { passes: kept.take(), ..Given::default() };
    let went_on = render_on(&scene, &more, &one, given, &mut |_| true, &mut |_| Ok(())).unwrap();
    assert_same_words("went on", floats(&across(&more, &[&one]).unwrap().image), floats(&went_on.image));
}

#[test]
fn parts_need_to_know_where_they_end() {
    let part = Some(Part { number: 1, of: 2 });
    for stop in [
        Stop { seconds: Some(1.0), ..Stop::default() },
        Stop { photons: Some(1), passes: Some(3), ..Stop::default() },
        Stop { error: Some(1.0), passes: Some(3), ..Stop::default() },
    ] {
        let settings = Settings { stop, ..progressive(1) };
        let given = Given { part, ..Given::default() };
        let result = render_on(&load("cornell"), &settings, &Device::cpu(), given, &mut |_| true, &mut |_| Ok(()));
        assert!(matches!(result, Err(RenderError::Setting { name: "part", .. })));
    }
}

/// A worker in a thread of this test, in place of another process.
struct Threads {
    to: Vec<Sender<Option<(WorkUnit, f32)>>>,
    from: Receiver<(usize, Vec<u8>)>,
    /// The bit to flip in the n-th message, to see that it is noticed.
    damage: Option<(usize, usize)>,
    received: usize,
    queued: VecDeque<(usize, Vec<u8>)>,
}

impl Remote for Threads {
    fn workers(&self) -> usize {
        self.to.len()
    }

    fn send(&mut self, worker: usize, unit: Option<(WorkUnit, f32)>) -> Result<(), RenderError> {
        self.to[worker].send(unit).expect("the worker listens");
        Ok(())
    }

    fn receive(&mut self) -> Result<Option<(usize, Vec<u8>)>, RenderError> {
        self.queued.extend(self.from.try_iter());
        let Some((worker, mut bytes)) = self.queued.pop_front() else { return Ok(None) };
        if let Some((_, byte)) = self.damage.filter(|(message, _)| *message == self.received) {
            let at = byte % bytes.len();
            bytes[at] ^= 1;
        }
        self.received += 1;
        Ok(Some((worker, bytes)))
    }
}

#[test]
fn workers_elsewhere_make_the_picture_of_one_whatever_they_send() {
    let scene = load("cornell");
    let settings = Settings { layers: vec![LayerKind::Albedo], ..progressive(9) };
    let expected = across(&settings, &[&Device::cpu()]).unwrap();
    // (devices of the workers, message that is damaged)
    for (name, lost_at, damage) in [
        ("two more", [u32::MAX; 2], None),
        ("one is lost", [u32::MAX, 50], None),
        ("one is lost at once", [0, u32::MAX], None),
        ("a header is damaged", [u32::MAX; 2], Some((1, 50))),
        ("a film is damaged", [u32::MAX; 2], Some((0, 20_000))),
    ] {
        std::thread::scope(|scope| {
            let (send, from) = mpsc::channel();
            let mut to = Vec::new();
            for (worker, lost_at) in lost_at.into_iter().enumerate() {
                let (orders, inbox) = mpsc::channel();
                to.push(orders);
                let (send, scene, settings) = (send.clone(), &scene, &settings);
                scope.spawn(move || {
                    compute_for(scene, settings, &faulty(lost_at, 0), None, &mut |bytes| {
                        if let Some(bytes) = bytes {
                            send.send((worker, bytes)).expect("somebody gathers");
                        }
                        Ok(inbox.recv().expect("somebody says what to do"))
                    })
                });
            }
            let mut threads = Threads { to, from, damage, received: 0, queued: VecDeque::new() };
            let given = Given { remote: Some(&mut threads), ..Given::default() };
            let own = faulty(u32::MAX, 2);
            let rendered = render_across(&scene, &settings, &[&own], given, &mut |_| true, &mut |_| Ok(())).unwrap();
            same(name, &expected, &rendered);
            let gave_up = rendered.report.notes.iter().any(|note| note.contains("given up"));
            let expects = damage.is_some() || lost_at != [u32::MAX; 2];
            assert_eq!(gave_up, expects, "{name}: {:?}", rendered.report.notes);
        });
    }
}
