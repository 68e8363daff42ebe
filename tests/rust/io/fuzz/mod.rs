//! A mutation fuzzer on the stable toolchain: fails if a reader panics, hangs or takes more than a gigabyte.
//!
//! Inputs are mutations of a corpus: changed bytes, lines, numbers and words. An input whose answer has new
//! words joins the corpus, so that later inputs get further into the reader. Runs with the same seed start
//! with the same inputs. `SUPPLE_FUZZ_SECONDS` is the duration per reader (20 by default), `SUPPLE_FUZZ_SEED`
//! the seed (1 by default). A failing input is written to the folder for temporary files, and the failure
//! names its path.

mod mutation;

use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use fastrand::Rng;
use mutation::Mutation;

/// The longest time that a reader may take for an input of at most [`MAX_INPUT`] bytes.
const TIME_LIMIT: Duration = Duration::from_secs(5);

/// The largest size of an input in bytes.
const MAX_INPUT: usize = 1 << 16;

/// The largest number of inputs in the corpus.
const MAX_CORPUS: usize = 4096;

/// The largest permitted peak memory of the process, in kB.
const MEMORY_LIMIT: u64 = 1_000_000;

/// A reader under test.
pub(crate) struct Target {
    /// Name of the reader, in messages and as the stem of the file with a failing input.
    pub(crate) name: &'static str,
    /// Words of its input language.
    pub(crate) words: &'static [&'static str],
    /// Reads an input, checks the result and describes it in words.
    pub(crate) read: fn(&[u8]) -> String,
}

/// Runs a reader on mutations of `corpus` for the configured duration.
#[allow(clippy::print_stdout, reason = "the log of a long run needs its statistics")]
pub(crate) fn fuzz(target: &Target, corpus: Vec<Vec<u8>>) {
    let number = |name: &str, default| {
        std::env::var(name).map_or(default, |text| text.parse().expect("a whole number"))
    };
    let (seconds, seed) = (number("SUPPLE_FUZZ_SECONDS", 20), number("SUPPLE_FUZZ_SEED", 1));
    let end = Instant::now() + Duration::from_secs(seconds);
    let current: Mutex<Option<(Instant, Vec<u8>)>> = Mutex::new(None);
    let (inputs, answers) = std::thread::scope(|scope| {
        scope.spawn(|| watch(target, &current, end));
        run_until(target, corpus, &mut Rng::with_seed(seed), &current, end)
    });
    let memory = peak_memory().unwrap_or(0);
    println!("{}: {inputs} inputs, {answers} kinds of answer, {seconds} s, peak {memory} kB", target.name);
}

type Current = Mutex<Option<(Instant, Vec<u8>)>>;

/// Runs a reader until `end`. Returns the number of inputs and the number of kinds of answers.
fn run_until(
    target: &Target,
    mut corpus: Vec<Vec<u8>>,
    rng: &mut Rng,
    current: &Current,
    end: Instant,
) -> (u64, usize) {
    let mut answers = HashSet::new();
    let mut inputs = 0;
    for input in corpus.clone() {
        answers.insert(kind(&(target.read)(&input), &input));
    }
    while Instant::now() < end {
        let mut input = corpus[rng.usize(..corpus.len())].clone();
        for _ in 0..1 << rng.u32(0..5) {
            let other = rng.usize(..corpus.len());
            Mutation::any(rng).apply(&mut input, &corpus[other], target.words, rng);
            input.truncate(MAX_INPUT);
        }
        input.shrink_to_fit();
        inputs += 1;
        *current.lock().unwrap() = Some((Instant::now(), input.clone()));
        let answer = catch_unwind(AssertUnwindSafe(|| (target.read)(&input)));
        *current.lock().unwrap() = None;
        match answer {
            Err(_) => panic!("{} panics for the input {}", target.name, keep(target, &input).display()),
            Ok(answer) => {
                let memory = peak_memory().unwrap_or(0);
                if memory > MEMORY_LIMIT {
                    panic!("{memory} kB after the input {}", keep(target, &input).display());
                }
                if answers.insert(kind(&answer, &input)) && corpus.len() < MAX_CORPUS {
                    corpus.push(input);
                }
            }
        }
    }
    (inputs, answers.len())
}

/// Ends the process when one input takes too long: a thread that hangs cannot be stopped.
#[allow(clippy::print_stdout, reason = "the process ends here, so the message cannot be a panic")]
fn watch(target: &Target, current: &Current, end: Instant) {
    while Instant::now() < end + TIME_LIMIT {
        std::thread::sleep(Duration::from_millis(200));
        let Ok(current) = current.lock() else { return };
        if let Some((since, input)) = current.as_ref().filter(|(since, _)| since.elapsed() > TIME_LIMIT) {
            let path = keep(target, input);
            println!("{} has not answered for {:?} to {}", target.name, since.elapsed(), path.display());
            std::process::exit(101);
        }
        if current.is_none() && Instant::now() > end {
            return;
        }
    }
}

/// Returns up to 16 words of an answer that do not come from the input.
fn kind(answer: &str, input: &[u8]) -> String {
    let input = String::from_utf8_lossy(input);
    let words = answer.split(|c: char| !c.is_ascii_alphabetic());
    let own = words.filter(|word| word.len() > 1 && !input.contains(word));
    own.take(16).collect::<Vec<_>>().join(" ")
}

/// Writes a failing input to a file and returns its path.
fn keep(target: &Target, input: &[u8]) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{}.failing", target.name));
    std::fs::write(&path, input).expect("the folder for temporary files");
    path
}

/// Returns the peak memory of this process in kB, on systems with `/proc`.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().trim_end_matches(" kB").parse().ok()
}
