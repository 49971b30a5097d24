//! `stiction mesh`.

use std::path::PathBuf;

use stiction::Error;
use stiction::mesh::info;
use stiction::run::read_mesh;

use crate::output;

/// Look at meshes
#[derive(clap::Subcommand)]
pub enum Command {
    /// Groups, counts, size, quality, open edges and volume of a mesh file
    Info {
        /// The mesh file
        file: PathBuf,
        /// A folder outside that of the mesh file from which an .inp may include files; may be given several times
        #[arg(long, value_name = "DIR")]
        include: Vec<PathBuf>,
    },
}

/// Reads the mesh and reports what is in it.
pub fn run(command: &Command) -> Result<u8, Error> {
    let Command::Info { file, include } = command;
    let (mesh, notes) = read_mesh(file, 1.0, include)?;
    let mut text = format!("{}\n{}", file.display(), info(&mesh));
    notes.0.iter().for_each(|note| text += &format!("note: {note}\n"));
    output::out(&text);
    Ok(0)
}
