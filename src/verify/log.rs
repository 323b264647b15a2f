//! Reads a written log back, trusting nothing in it.

/// The largest sum of uncompressed messages that a log may hold, in bytes.
pub const MAX_DATA_BYTES: u64 = 512 * 1024 * 1024;

/// Name of the attachment that holds the schedule.
pub const SCHEDULE: &str = "schedule.json";

/// Name of the attachment that holds the claims.
pub const CLAIMS: &str = "claims.json";

/// What the names of attached source files begin with.
pub const SOURCE_PREFIX: &str = "source/";

/// Name of the metadata record that says where the log comes from.
pub const METADATA: &str = "tweeze";
