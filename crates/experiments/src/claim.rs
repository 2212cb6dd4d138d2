//! What the thesis says, and what the data say of that.

use serde::Serialize;

/// Whether a claim holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// It does.
    Holds,
    /// In part, or not everywhere.
    Partly,
    /// It does not.
    Fails,
    /// There are no data.
    Unmeasured,
}

impl Verdict {
    /// For people.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Partly => "holds in part",
            Self::Fails => "does not hold",
            Self::Unmeasured => "not measured",
        }
    }
}

/// A claim.
#[derive(Clone, Debug, Serialize)]
pub struct Claim {
    /// What the thesis says, with the section.
    pub says: &'static str,
    /// Whether that holds here.
    pub verdict: Verdict,
    /// The figures that the verdict is made of.
    pub because: String,
}

impl Claim {
    /// A claim judged by data; without data, not judged.
    pub(crate) fn judge(says: &'static str, data: Option<(Verdict, String)>) -> Self {
        let (verdict, because) =
            data.unwrap_or((Verdict::Unmeasured, "not all of what it takes was measured here.".to_string()));
        Self { says, verdict, because }
    }
}

/// [`Verdict::Holds`] if all of the conditions do, [`Verdict::Fails`] if none does.
pub(crate) fn all(conditions: &[bool]) -> Verdict {
    match conditions.iter().filter(|&&condition| condition).count() {
        0 => Verdict::Fails,
        n if n == conditions.len() => Verdict::Holds,
        _ => Verdict::Partly,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdicts_are_of_all_some_and_none() {
        assert_eq!(all(&[true, true]), Verdict::Holds);
        assert_eq!(all(&[true, false]), Verdict::Partly);
        assert_eq!(all(&[false]), Verdict::Fails);
        assert_eq!(Claim::judge("x", None).verdict, Verdict::Unmeasured);
    }
}
