//! Plans: what is to be done, as data.

use crate::buffer::Buffer;
use crate::kernel::Masked;

/// A list of stages over buffers, executed in order. Each stage sees what the ones before it wrote.
#[derive(Clone, Default)]
pub struct Plan {
    pub(crate) steps: Vec<Step>,
    scope: String,
}

#[derive(Clone)]
pub(crate) enum Step {
    /// Fills a buffer with zeros.
    Clear { stage: String, buffer: Buffer },
    /// Runs a kernel.
    Run { stage: String, kernel: Masked, groups: u32, buffers: Vec<Buffer> },
}

impl Plan {
    /// An empty plan.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A plan of one step.
    pub(crate) fn of(step: Step) -> Self {
        Self { steps: vec![step], scope: String::new() }
    }

    /// Names the stages that follow `scope/stage`, for reports: the same kernels build several maps.
    pub fn scope(&mut self, scope: &str) {
        self.scope = scope.to_string();
    }

    fn stage(&self, name: &str) -> String {
        if self.scope.is_empty() { name.to_string() } else { format!("{}/{name}", self.scope) }
    }

    /// Appends the stages of another plan, under their names there.
    pub fn append(&mut self, other: &Self) {
        self.steps.extend_from_slice(&other.steps);
    }

    /// Fills a buffer with zeros.
    pub fn clear(&mut self, buffer: &Buffer) {
        self.steps.push(Step::Clear { stage: self.stage("clear"), buffer: buffer.clone() });
    }

    /// Runs a kernel with at least one invocation for each of `count` elements.
    ///
    /// # Panics
    /// If the buffers are not those of the kernel.
    pub fn each(&mut self, kernel: impl Into<Masked>, count: u32, buffers: &[&Buffer]) {
        let masked = kernel.into();
        self.groups(masked, count.div_ceil(masked.kernel.lanes()), buffers);
    }

    /// Runs a kernel with `groups` workgroups.
    ///
    /// # Panics
    /// If the number of buffers is not the kernel's, or if the kernel would write a buffer that it is given twice.
    pub fn groups(&mut self, kernel: impl Into<Masked>, groups: u32, buffers: &[&Buffer]) {
        let masked = kernel.into();
        let kernel = masked.kernel;
        let bindings = kernel.bindings();
        assert_eq!(bindings.len(), buffers.len(), "{}: number of buffers", kernel.entry_point());
        for (i, (written, binding)) in buffers.iter().zip(bindings).enumerate() {
            if binding.access.writes() {
                let shared = buffers.iter().enumerate().any(|(j, other)| i != j && written.is(other));
                assert!(!shared, "{}: `{}` is written and bound twice", kernel.entry_point(), binding.name);
            }
        }
        if groups > 0 {
            let buffers = buffers.iter().map(|&b| b.clone()).collect();
            self.steps.push(Step::Run { stage: self.stage(kernel.entry_point()), kernel: masked, groups, buffers });
        }
    }

    /// The first and the last stage, to say where an error was.
    pub(crate) fn extent(&self) -> String {
        let name = |step: &Step| match step {
            Step::Clear { stage, .. } | Step::Run { stage, .. } => stage.clone(),
        };
        match (self.steps.first(), self.steps.last()) {
            (Some(first), Some(last)) => format!("{} … {}", name(first), name(last)),
            _ => "nothing".to_string(),
        }
    }
}
