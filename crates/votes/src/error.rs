//! Why a report is refused, or a store cannot be used.
//!
//! Owns [`VotesError`]. Never prints one.

use std::io;

/// What went wrong.
#[derive(Debug, thiserror::Error)]
pub enum VotesError {
    /// The totals of a report cannot be those of showings in this time.
    #[error(
        "the totals of ledger {ledger} grow faster than showings can: {found} showings, at most {most} by day {day}"
    )]
    Growth {
        /// The ledger.
        ledger: String,
        /// The showings of all its sheep.
        found: u64,
        /// What the time allows.
        most: u64,
        /// The day of the check, since 1970.
        day: u32,
    },
    /// The report has more bytes than a report may have.
    #[error("the report has {found} bytes, at most {most} are read")]
    Large {
        /// Its bytes.
        found: usize,
        /// The limit.
        most: usize,
    },
    /// A unit has reported more ledgers than a unit can have.
    #[error("unit `{unit}` has {most} ledgers already, ledger {ledger} is refused")]
    Ledgers {
        /// The unit.
        unit: String,
        /// The new one.
        ledger: String,
        /// The limit.
        most: usize,
    },
    /// The document is not in the form that is expected.
    #[error("the votes are malformed: {message}")]
    Malformed {
        /// What is wrong with it.
        message: String,
    },
    /// The day on which a ledger began cannot be, or is another one than before.
    #[error("ledger {ledger} cannot have begun on day {found}: expected {expected}")]
    Since {
        /// The ledger.
        ledger: String,
        /// The day that it has.
        found: u32,
        /// In words.
        expected: String,
    },
    /// The files of a store cannot be read or written.
    #[error("cannot {doing} the votes in `{path}`")]
    Store {
        /// The operation.
        doing: &'static str,
        /// The folder.
        path: String,
        /// What the file system says.
        source: io::Error,
    },
    /// All ledgers of a unit together have more showings than there can have been.
    #[error(
        "the {ledgers} ledgers of unit `{unit}` together grow faster than showings can: {found} showings, at most {most} \
         by day {day}"
    )]
    Sum {
        /// The unit.
        unit: String,
        /// How many there would be.
        ledgers: usize,
        /// The showings of all of them.
        found: u64,
        /// What the time since the first one began allows.
        most: u64,
        /// The day of the check, since 1970.
        day: u32,
    },
    /// Nobody has told of this unit.
    #[error("unit `{unit}` is not one of those that are known")]
    Unknown {
        /// The unit, as far as it is a name.
        unit: String,
    },
}
