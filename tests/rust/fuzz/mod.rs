//! Throws mutated inputs at a reader, on the stable toolchain: never a panic, a hang, or more than a gigabyte.
//!
//! Inputs are made from a corpus by changes of bytes, lines, numbers and words. What a reader answers to for the first
//! time, judged by the words of its answer, joins the corpus: so later inputs get further in. Each run of the same
//! seed begins alike. `SUPPLE_FUZZ_SECONDS` sets how long a reader is tried (20 by default), `SUPPLE_FUZZ_SEED` where the
//! numbers begin. An input that fails is left in the folder for temporary files, and named.

mod mutation;

use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use fastrand::Rng;
use mutation::Mutation;

/// The longest that a reader may take for an input of at most [`LONGEST`] bytes.
const SLOWEST: Duration = Duration::from_secs(5);

/// Bytes of an input.
const LONGEST: usize = 1 << 16;

/// Inputs that are kept to be changed further.
const CORPUS: usize = 4096;

/// Most memory that the process may have taken, in kB.
const MEMORY: u64 = 1_000_000;

/// A reader that is tried.
pub(crate) struct Target {
    /// Of files with failing inputs.
    pub(crate) name: &'static str,
    /// Words and numbers that mean something to it.
    pub(crate) words: &'static [&'static str],
    /// Reads an input, checks what it can, and says in words what came out.
    pub(crate) read: fn(&[u8]) -> String,
}

/// Tries a reader.
#[allow(clippy::print_stdout, reason = "what a run of minutes has seen is to be recorded")]
pub(crate) fn fuzz(target: &Target, corpus: Vec<Vec<u8>>) {
    let number = |name: &str, default| {
        std::env::var(name).map_or(default, |text| text.parse().expect("a whole number"))
    };
    let (seconds, seed) = (number("SUPPLE_FUZZ_SECONDS", 20), number("SUPPLE_FUZZ_SEED", 1));
    let end = Instant::now() + Duration::from_secs(seconds);
    let current: Mutex<Option<(Instant, Vec<u8>)>> = Mutex::new(None);
    let (inputs, answers) = std::thread::scope(|scope| {
        scope.spawn(|| watch(target, &current, end));
        try_until(target, corpus, &mut Rng::with_seed(seed), &current, end)
    });
    let memory = peak_memory().unwrap_or(0);
    println!("{}: {inputs} inputs, {answers} kinds of answer, {seconds} s, peak {memory} kB", target.name);
}

type Current = Mutex<Option<(Instant, Vec<u8>)>>;

fn try_until(
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
            input.truncate(LONGEST);
        }
        input.shrink_to_fit();
        inputs += 1;
        *current.lock().unwrap() = Some((Instant::now(), input.clone()));
        let answer = catch_unwind(AssertUnwindSafe(|| (target.read)(&input)));
        *current.lock().unwrap() = None;
        match answer {
            Err(_) => panic!("{} panics at {}", target.name, keep(target, &input).display()),
            Ok(answer) => {
                let memory = peak_memory().unwrap_or(0);
                if memory > MEMORY {
                    panic!("{memory} kB, after {}", keep(target, &input).display());
                }
                if answers.insert(kind(&answer, &input)) && corpus.len() < CORPUS {
                    corpus.push(input);
                }
            }
        }
    }
    (inputs, answers.len())
}

/// Ends the process where one input takes too long: a thread that hangs cannot be stopped.
#[allow(clippy::print_stdout, reason = "nothing else can be said before the process ends")]
fn watch(target: &Target, current: &Current, end: Instant) {
    while Instant::now() < end + SLOWEST {
        std::thread::sleep(Duration::from_millis(200));
        let Ok(current) = current.lock() else { return };
        if let Some((since, input)) = current.as_ref().filter(|(since, _)| since.elapsed() > SLOWEST) {
            let path = keep(target, input);
            println!("{} has not answered for {:?} to {}", target.name, since.elapsed(), path.display());
            std::process::exit(101);
        }
        if current.is_none() && Instant::now() > end {
            return;
        }
    }
}

/// The words of an answer that are its own, and not the input's.
fn kind(answer: &str, input: &[u8]) -> String {
    let input = String::from_utf8_lossy(input);
    let words = answer.split(|c: char| !c.is_ascii_alphabetic());
    let own = words.filter(|word| word.len() > 1 && !input.contains(word));
    own.take(16).collect::<Vec<_>>().join(" ")
}

fn keep(target: &Target, input: &[u8]) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{}.failing", target.name));
    std::fs::write(&path, input).expect("the folder for temporary files");
    path
}

/// The most memory that this process ever had, in kB, where the system says so.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().trim_end_matches(" kB").parse().ok()
}
