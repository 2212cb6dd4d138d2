//! The kernels as values: what a plan names, and how the CPU calls them.

use crate::cpu::{Bound, Groups};
use crate::{Precision, Record};
use caustic_kernels::gather::*;
use caustic_kernels::grid::{self, *};
use caustic_kernels::layout::*;
use caustic_kernels::probe::*;
use caustic_kernels::rivals::{self, *};
use caustic_kernels::sort::{self, *};
use caustic_kernels::trace::{self, *};
use caustic_kernels::{gather, probe, stages};

/// How a stage uses a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// One record, read.
    One,
    /// Records, read.
    In,
    /// Records, written and not read.
    Out,
    /// Records, changed in place: read and written.
    InOut,
}

impl Access {
    /// Whether the stage changes the buffer.
    #[must_use]
    pub fn writes(self) -> bool {
        matches!(self, Self::Out | Self::InOut)
    }
}

/// A buffer of a stage.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    /// What it is to the kernel.
    pub name: &'static str,
    /// How it is used.
    pub access: Access,
    /// Bytes of a record.
    pub record_bytes: u32,
    /// Which of its words are floats: [`Record::WORDS`].
    pub words: &'static str,
}

/// A kernel with the mask of what it knows: what a plan runs. Kernels without a mask know what they know.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Masked {
    /// The kernel.
    pub kernel: Kernel,
    /// Bits of [`trace::known`].
    pub known: u32,
}

impl From<Kernel> for Masked {
    fn from(kernel: Kernel) -> Self {
        kernel.knowing(EVERYTHING)
    }
}

macro_rules! kernels {
    ($($shape:ident $(($($detail:tt)*))? $name:ident = $entry:ident [$lanes:tt]
       ($($b:tt $arg:ident: $access:ident $t:ty),*) = $module:ident::$body:ident $([$($generic:tt),*])?;)*) => {
        /// A kernel: one stage of a plan. The list is made from `caustic_kernels::stages!`.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[allow(missing_docs)] // documented where the bodies are
        pub enum Kernel { $($name),* }

        impl Kernel {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$name),*];

            /// Name of the SPIR-V entry point, and of the stage in reports.
            #[must_use]
            pub fn entry_point(self) -> &'static str {
                match self { $(Self::$name => stringify!($entry)),* }
            }

            /// Its SPIR-V, as `cargo xtask shaders` made it.
            fn spirv(self, precision: Precision) -> &'static [u8] {
                match (self, precision) {
                    $(
                        (Self::$name, Precision::Exact) => {
                            include_bytes!(concat!("../shaders/", stringify!($entry), ".spv"))
                        }
                        (Self::$name, Precision::Fast) => {
                            include_bytes!(concat!("../shaders/fast/", stringify!($entry), ".spv"))
                        }
                    )*
                }
            }

            /// Its SPIR-V as words.
            pub(crate) fn words(self, precision: Precision) -> Vec<u32> {
                let bytes = self.spirv(precision).chunks_exact(4);
                bytes.map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
            }

            /// The kernel whose entry point is called so.
            #[must_use]
            pub fn named(entry_point: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|kernel| kernel.entry_point() == entry_point)
            }

            /// Lanes of a workgroup.
            #[must_use]
            pub fn lanes(self) -> u32 {
                match self { $(Self::$name => $lanes),* }
            }

            /// Its buffers, in the order of their binding numbers.
            #[must_use]
            pub fn bindings(self) -> &'static [Binding] {
                match self {
                    $(Self::$name => const { &[$(Binding {
                        name: stringify!($arg),
                        access: Access::$access,
                        record_bytes: size_of::<$t>() as u32,
                        words: <$t as Record>::WORDS,
                    }),*] }),*
                }
            }

            /// The kernel with a mask of what it is to [know](caustic_kernels::trace::known), for those that take one.
            #[must_use]
            pub fn knowing(self, known: u32) -> Masked {
                Masked { kernel: self, known }
            }

            /// Runs all its workgroups on the CPU.
            pub(crate) fn run_on_cpu(self, groups: &Groups, bound: &[Bound]) {
                match self {
                    $(Self::$name => {
                        $(let $arg = bind!($access $t, bound[$b]);)*
                        run!($shape $(($($detail)*))?, groups, $lanes, $module::$body $([$($generic),*])?, $($access $arg),*);
                    })*
                }
            }
        }
    };
}

/// The type with which the CPU sees a buffer.
macro_rules! bind {
    (One $t:ty, $bound:expr) => {
        &$bound.read::<$t>()[0]
    };
    (In $t:ty, $bound:expr) => {
        $bound.read::<$t>()
    };
    (Out $t:ty, $bound:expr) => {
        $bound.write::<$t>()
    };
    (InOut $t:ty, $bound:expr) => {
        $bound.write::<$t>()
    };
}

/// Hands a buffer to a body: each call has its own handle of what is written.
macro_rules! pass {
    (One $arg:ident) => {
        $arg
    };
    (In $arg:ident) => {
        $arg
    };
    (Out $arg:ident) => {
        &mut $arg.clone()
    };
    (InOut $arg:ident) => {
        &mut $arg.clone()
    };
}

macro_rules! run {
    (each, $groups:expr, $lanes:tt, $module:ident::$body:ident $([$($generic:tt),*])?, $($access:ident $arg:ident),*) => {
        $groups.each($lanes, |i| $module::$body$(::<$($generic),*>)?(i, $(pass!($access $arg)),*))
    };
    // Nothing and everything are known to the compiler, and other masks a branch each.
    (masked, $groups:expr, $lanes:tt, $module:ident::$body:ident, $($access:ident $arg:ident),*) => {
        match $groups.known {
            0 => $groups.each($lanes, |i| $module::$body(Only::<0>, i, $(pass!($access $arg)),*)),
            EVERYTHING => $groups.each($lanes, |i| $module::$body(ALL, i, $(pass!($access $arg)),*)),
            mask => $groups.each($lanes, |i| $module::$body(Told(mask), i, $(pass!($access $arg)),*)),
        }
    };
    (batch($registers:ty), $groups:expr, $lanes:tt, $module:ident::$body:ident, $($access:ident $arg:ident),*) => {
        $groups.batches::<$registers>($lanes, |batch| $module::$body(batch, $(pass!($access $arg)),*))
    };
    (gather($container:ty), $groups:expr, $lanes:tt, $module:ident::$body:ident, $($access:ident $arg:ident),*) => {
        $groups.each($lanes, |i| $module::$body(i, <$container>::new(), $(pass!($access $arg)),*))
    };
    (columns($shared:ty), $groups:expr, $lanes:tt, $module:ident::$body:ident $([$($generic:tt),*])?, $($access:ident $arg:ident),*) => {
        $groups.columns::<$shared>($lanes, |i, lane, shared| $module::$body$(::<$($generic),*>)?(i, lane, shared, $(pass!($access $arg)),*))
    };
    (group($registers:ty; $shared:ty), $groups:expr, $lanes:tt, $module:ident::$body:ident,
     $($access:ident $arg:ident),*) => {
        $groups.phases::<$registers, $shared>($lanes, 1, |lanes, group, shared| {
            $module::$body(lanes, group, shared, $(pass!($access $arg)),*);
        })
    };
    (lanes($registers:ident; $shared:ty), $($rest:tt)*) => {
        run!(subgroups($registers; $shared), $($rest)*)
    };
    // One lane does a block fastest. Where the order of lanes is on trial, they are as many as a GPU's.
    (subgroups($registers:ident; $shared:ty), $groups:expr, $lanes:tt, $module:ident::$body:ident,
     $($access:ident $arg:ident),*) => {
        match $groups.subgroup_lanes() {
            None => $groups.phases::<$registers<{ SORT_BLOCK as usize }>, $shared>(1, 1, |lanes, group, shared| {
                $module::$body(lanes, group, shared, $(pass!($access $arg)),*);
            }),
            Some(subgroup) => {
                $groups.phases::<$registers<{ (SORT_BLOCK / $lanes) as usize }>, $shared>(
                    $lanes,
                    subgroup,
                    |lanes, group, shared| {
                        $module::$body(lanes, group, shared, $(pass!($access $arg)),*);
                    },
                )
            }
        }
    };
}

stages!(kernels);
