//! The plan that a render starts from, and `caustic plan`, which shows it.

use crate::Failure;
use crate::args::{CostsArgument, RadiusArgument, RenderArguments};
use crate::progress::Monitor;
use crate::render::{failure, settings};
use caustic_device::Device;
use caustic_planner::{
    Budget, Choice, Finding, Given, Line, Prediction, Quality, Scout, Survey, Surveyor, advice, explain, findings, fit,
    foresee, settle,
};
use caustic_renderer::scene::{CompiledScene, Scene};
use caustic_renderer::{DEFAULT_PASSES, Integrator, Progress, RenderError, RenderReport, Settings, Stop};
use serde_json::{Value, json};

/// Passes that a render which ends by something else is predicted with.
const UNKNOWN_PASSES: u32 = 16;

/// What a render is going to do.
pub struct Planned {
    pub settings: Settings,
    compiled: CompiledScene,
    lines: Vec<Line>,
    findings: Vec<Finding>,
    survey: Option<Survey>,
    prediction: Option<Prediction>,
    /// Whether a budget can be met; nothing if there is none.
    met: Option<bool>,
}

/// Prints the plan of a render, and renders nothing.
pub fn run(arguments: &RenderArguments) -> Result<(), Failure> {
    let scene = Scene::load(&arguments.scene).map_err(Failure::input)?;
    let asked = settings(arguments, &scene, None);
    asked.validate().map_err(|error| failure(&error))?;
    // Of several devices, the first is what is planned for.
    let opened = Device::open_several(&arguments.device, arguments.precision.into()).map_err(Failure::input)?;
    let Some((device, line)) = opened.into_iter().next() else { unreachable!("there is a device, or an error") };
    if !arguments.quiet {
        eprintln!("{line}");
    }
    let mut monitor = Monitor::new(arguments.quiet);
    let mut planned = Planned::new(arguments, &scene, asked, &device, &mut monitor)?;
    planned.survey(arguments, &scene, &device, &mut monitor)?;
    if arguments.json {
        let mut value = planned.json();
        value["scene"] = scene.name.into();
        value["device"] = device.name().into();
        println!("{value:#}");
    } else {
        println!("{}", planned.text());
    }
    match planned.findings.iter().find(|finding| finding.broken) {
        Some(finding) => Err(Failure::input(&finding.text)),
        None => Ok(()),
    }
}

impl Planned {
    /// Plans a render of `asked`: chooses what a budget leaves open, and explains all.
    pub fn new(
        arguments: &RenderArguments,
        scene: &Scene,
        asked: Settings,
        device: &Device,
        monitor: &mut Monitor,
    ) -> Result<Self, Failure> {
        let compiled = scene.compile_with(&asked.forced);
        let mut planned = Self {
            findings: Vec::new(),
            lines: Vec::new(),
            settings: asked,
            compiled,
            survey: None,
            prediction: None,
            met: None,
        };
        let budget = budget(arguments);
        if let Some(budget) = &budget {
            planned.choose(arguments, scene, budget, device, monitor)?;
        } else if let Some(bytes) = limit(arguments) {
            planned.limit(arguments, scene, bytes, device, monitor)?;
        } else if arguments.plan.explain {
            planned.survey(arguments, scene, device, monitor)?;
        }
        planned.lines = explain(scene, &planned.compiled, &planned.settings, device, budget.is_some());
        planned.findings = findings(scene, &planned.compiled, &planned.settings, device);
        Ok(planned)
    }

    /// Takes settings from the planner where the arguments leave them open.
    fn choose(
        &mut self,
        arguments: &RenderArguments,
        scene: &Scene,
        budget: &Budget,
        device: &Device,
        monitor: &mut Monitor,
    ) -> Result<(), Failure> {
        let given = Given {
            photons: arguments.photons.is_some(),
            caustic_photons: arguments.caustic_photons.is_some(),
            k: arguments.k.is_some(),
            radius: matches!(arguments.radius, Some(RadiusArgument::Metres(_))),
            spp: arguments.spp.is_some(),
        };
        // The stops of a budget are found again below.
        self.settings.stop = Stop::default();
        let Self { compiled, settings, .. } = &*self;
        let (survey, choice) = surveying(arguments, scene, device, monitor, |surveyor| {
            settle(surveyor, compiled, settings, given, budget, device)
        })?;
        let Choice { settings, prediction, met } = choice;
        let passes = settings.stop.passes;
        self.settings = settings;
        self.settings.stop = match (arguments.plan.quality, budget.error, budget.seconds) {
            // Noise is seen only between passes.
            (None, Some(error), _) if error > prediction.bias => Stop {
                passes: passes.map(|passes| passes.saturating_mul(4)),
                error: Some(error - prediction.bias),
                ..Stop::default()
            },
            (None, None, Some(seconds)) => Stop { seconds: Some(seconds), ..Stop::default() },
            _ => Stop { passes, ..Stop::default() },
        };
        (self.survey, self.prediction, self.met) = (Some(survey), Some(prediction), Some(met));
        Ok(())
    }

    /// Has photons in chunks if whole maps do not fit.
    fn limit(
        &mut self,
        arguments: &RenderArguments,
        scene: &Scene,
        bytes: u64,
        device: &Device,
        monitor: &mut Monitor,
    ) -> Result<(), Failure> {
        let Self { compiled, settings, .. } = &*self;
        let fitted = surveying(arguments, scene, device, monitor, |surveyor| {
            let survey = surveyor.survey(settings)?;
            match fit(&survey, compiled, settings, bytes, device) {
                Ok(fitted) => Ok(Ok((foresee(surveyor, compiled, &fitted, passes(&fitted), device)?, fitted))),
                Err(least) => Ok(Err(least)),
            }
        })?;
        let (survey, settings) = fitted.map_err(|least| {
            let least = least.div_ceil(1 << 20);
            Failure::input(format!(
                "--memory {:.1} MiB is too little: give at least {least}MiB, or fewer --photons or a smaller --size",
                mib(bytes)
            ))
        })?;
        self.settings = settings;
        self.settings.validate().map_err(|error| failure(&error))?;
        self.prediction = Some(survey.predict(&self.compiled, &self.settings, passes(&self.settings), device));
        (self.survey, self.met) = (Some(survey), Some(true));
        Ok(())
    }

    /// Predicts the render, if that was not done.
    fn survey(
        &mut self,
        arguments: &RenderArguments,
        scene: &Scene,
        device: &Device,
        monitor: &mut Monitor,
    ) -> Result<(), Failure> {
        if self.survey.is_some() {
            return Ok(());
        }
        let Self { compiled, settings, .. } = &*self;
        let passes = passes(settings);
        let survey = surveying(arguments, scene, device, monitor, |surveyor| {
            foresee(surveyor, compiled, settings, passes, device)
        })?;
        self.prediction = Some(survey.predict(&self.compiled, &self.settings, passes, device));
        self.survey = Some(survey);
        Ok(())
    }

    /// Tells the user, on standard error: everything if asked, and else what is chosen or may go wrong.
    pub fn tell(&self, everything: bool) {
        if everything {
            eprintln!("{}", self.text());
            return;
        }
        for finding in &self.findings {
            eprintln!("warning: {}", finding.text);
        }
        if let (Some(prediction), Some(_)) = (&self.prediction, self.met) {
            let Settings { photons, caustic_photons, k, radius, spp, table, .. } = self.settings;
            let table = table.map_or(String::new(), |table| format!(" --table {table}"));
            let chunk = self.settings.chunk.map_or(String::new(), |chunk| format!(" --chunk {}", chunk.photons));
            eprintln!(
                "plan: --photons {photons} --caustic-photons {caustic_photons} --k {k} --radius {radius} --spp {spp}{table}{chunk}, {} passes",
                prediction.passes
            );
            eprintln!("{}", foreseen(prediction));
            self.complain();
        }
    }

    fn complain(&self) {
        if self.met == Some(false) {
            eprintln!("warning: nothing that was tried is within the budget; this is the nearest to it");
        }
    }

    /// The plan as text.
    fn text(&self) -> String {
        let mut text = String::new();
        for Line { what, choice, why } in &self.lines {
            text += &format!("  {what:<16} {choice:<16} {why}\n");
        }
        for finding in &self.findings {
            text += &format!("warning: {}\n", finding.text);
        }
        if let Some(prediction) = &self.prediction {
            text += &foreseen(prediction);
        }
        if self.met == Some(false) {
            text += "\nwarning: nothing that was tried is within the budget; this is the nearest to it";
        }
        text.trim_end().to_string()
    }

    /// The plan for programs.
    pub fn json(&self) -> Value {
        json!({
            "decisions": self.lines,
            "findings": self.findings,
            "prediction": self.prediction,
            "within_budget": self.met,
            "settings": {
                "photons": self.settings.photons,
                "caustic_photons": self.settings.caustic_photons,
                "k": self.settings.k,
                "radius": self.settings.radius,
                "spp": self.settings.spp,
                "table": self.settings.table,
                "chunk": self.settings.chunk.map(|chunk| json!({"photons": chunk.photons, "samples": chunk.samples})),
                "passes": self.prediction.as_ref().map(|prediction| prediction.passes),
            },
        })
    }

    /// Compares what was foreseen with what came, and advises.
    pub fn compare(&self, report: &RenderReport, device: &Device) {
        let (Some(survey), true) = (&self.survey, report.passes > 0) else { return };
        let then = survey.predict(&self.compiled, &self.settings, report.passes, device);
        let ratio = |predicted: f64, actual: f64| format!("{:+.0} %", 100.0 * (predicted / actual - 1.0));
        let mut text = format!(
            "foreseen for {} passes: time {:.2} s, {} of what it took; memory {:.1} MiB, {}",
            report.passes,
            then.seconds,
            ratio(then.seconds, report.seconds),
            mib(then.bytes),
            ratio(then.bytes as f64, report.peak_bytes as f64)
        );
        if let Some(noise) = report.noise {
            text += &format!("; noise {:.1e}, {:.2} times what passes show", then.noise, then.noise / noise);
        }
        eprintln!("{text}");
        eprintln!("{}", advice(survey, &self.compiled, &self.settings, report, device));
    }
}

fn foreseen(prediction: &Prediction) -> String {
    let Prediction { passes, seconds, bytes, noise, bias, .. } = prediction;
    let passes = if *passes == 1 { "1 pass".to_string() } else { format!("{passes} passes") };
    format!(
        "foreseen: {seconds:.2} s for {passes}, {:.1} MiB at the most; relMSE {:.1e}, of it noise {noise:.1e} and blur {bias:.1e}",
        mib(*bytes),
        prediction.error()
    )
}

fn mib(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 20)
}

/// The budget that arguments name. `--time` and `--error` are one only where nothing else says how many passes there are, and a pass is
/// what k photons an estimate make of it: elsewhere they just end a render.
fn budget(arguments: &RenderArguments) -> Option<Budget> {
    let how = &arguments.how;
    let bytes = arguments.plan.memory.filter(|_| limit(arguments).is_none());
    let chosen = arguments.plan.quality.is_some() || bytes.is_some();
    let ends = how.time.is_some() || how.error.is_some();
    let open = how.passes.is_none() && how.total_photons.is_none() && how.checkpoint.is_none();
    let photon = Integrator::from(how.integrator) == Integrator::Photon && arguments.load_map.is_none();
    (photon && (chosen || ends && open)).then(|| Budget {
        error: arguments.plan.quality.map(|quality| Quality::from(quality).error()).or(how.error),
        seconds: how.time,
        bytes,
    })
}

/// Most bytes of a render whose photons are given, so that what does not fit comes in chunks.
fn limit(arguments: &RenderArguments) -> Option<u64> {
    let given = match Integrator::from(arguments.how.integrator) {
        Integrator::Photon => arguments.photons.is_some(),
        Integrator::Progressive => true,
        Integrator::Path | Integrator::Direct => false,
    };
    arguments.plan.memory.filter(|_| given && arguments.load_map.is_none())
}

/// Whether what is chosen for a budget depends on how fast this machine is.
pub fn differs_between_machines(arguments: &RenderArguments) -> bool {
    budget(arguments).is_some() && matches!(arguments.plan.costs, CostsArgument::Measured)
}

/// Passes that are foreseen without a budget.
fn passes(settings: &Settings) -> u32 {
    let unknown = settings.stop != Stop::default();
    settings.stop.passes.unwrap_or(match settings.integrator {
        _ if unknown => UNKNOWN_PASSES,
        Integrator::Progressive => DEFAULT_PASSES,
        _ => 1,
    })
}

/// Lets a surveyor of the scene work, and leaves the device as it was.
fn surveying<T>(
    arguments: &RenderArguments,
    scene: &Scene,
    device: &Device,
    monitor: &mut Monitor,
    work: impl FnOnce(&mut Surveyor<'_>) -> Result<T, RenderError>,
) -> Result<T, Failure> {
    let mut done = 0;
    let mut go_on = || {
        done += 1;
        // How many small steps there are is not known: the bar shows that something happens.
        monitor.show(Progress { phase: "survey", done: done % 100, total: 100 })
    };
    let scout = Scout::new(scene, device, arguments.plan.costs.into(), &mut go_on);
    let worked = work(&mut Surveyor::new(scout, caustic_planner::cache::folder()));
    monitor.finish();
    device.reset_stage_times();
    device.trim();
    device.reset_peak_bytes();
    worked.map_err(|error| failure(&error))
}
