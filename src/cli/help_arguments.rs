//! Arguments of `explain`, `new`, `completions` and `man`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use clap_complete::Shell;

/// `sphecs explain`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    sphecs explain\n  \
    sphecs explain outlets.condition\n  \
    sphecs explain scheme.Wcsph.shifting\n  \
    sphecs explain WaveEquation\n\n\
    Numbers of list items may stand in a path, as in `outlets.0.condition`; names of choices may be left out.")]
pub struct ExplainArguments {
    /// Field or choice of a scene file [default: the fields of a scene]
    #[arg(value_name = "PATH", default_value = "", hide_default_value = true)]
    pub path: String,
}

/// `sphecs new`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    sphecs new channel my_channel\n  \
    sphecs my_channel.ron --smoke\n\n\
    An existing file is never replaced.")]
pub struct NewArguments {
    /// Flow to begin with
    #[arg(value_name = "FLOW")]
    pub template: Template,
    /// Name of the scene; the file is NAME.ron
    #[arg(value_name = "NAME")]
    pub name: PathBuf,
}

/// A scene to begin with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Template {
    /// 2D channel with an inlet and an outlet
    Channel,
    /// 3D pipe with a mass-flow inlet
    Pipe,
    /// 3D pipe with a bend of 90 degrees
    Bend,
    /// 2D cylinder in a stream, with drag and lift
    Cylinder,
    /// 2D cavity with a sliding lid
    Cavity,
}

/// `sphecs completions`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    sphecs completions bash > ~/.local/share/bash-completion/completions/sphecs\n  \
    sphecs completions fish > ~/.config/fish/completions/sphecs.fish")]
pub struct CompletionsArguments {
    /// Shell
    #[arg(value_name = "SHELL")]
    pub shell: Shell,
}

/// `sphecs man`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    sphecs man | man -l -\n  \
    sphecs man --dir ~/.local/share/man/man1")]
pub struct ManArguments {
    /// Folder in which to write the page of the program and one of each command [default: print the
    /// page of the program]
    #[arg(long, value_name = "DIR")]
    pub dir: Option<PathBuf>,
}
