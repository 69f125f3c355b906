//! Page with the state of a run, for a browser on this machine.
//!
//! It listens on 127.0.0.1 alone, answers `GET` alone, and refuses requests that another page makes
//! under another name of this machine. The page is one file without a build step.

use std::io::Cursor;
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};

use tiny_http::{Header, Method, Request, Response, Server, StatusCode};

use crate::cli::failure::Failure;
use sphecs_output::error::OutputError;
use sphecs_output::live::LiveState;
use sphecs_output::picture::{self, Field, RenderOptions};
use sphecs_output::results::Results;
use sphecs_run::console::Console;

/// The page.
const PAGE: &str = include_str!("../../../assets/watch.html");

/// Width of the picture, pixels.
const WIDTH: u32 = 1200;

type Answer = Response<Cursor<Vec<u8>>>;

/// Answers requests until the process is stopped.
///
/// # Errors
/// [`Failure::Output`] for a port that is taken.
pub(super) fn serve(run: &Path, port: u16) -> Result<(), Failure> {
    let taken = |error: Box<dyn std::error::Error + Send + Sync>| {
        OutputError::Request(format!("port {port} of 127.0.0.1: {error}; give another one by `--serve PORT`"))
    };
    let server = Server::http((Ipv4Addr::LOCALHOST, port)).map_err(taken)?;
    let port = server.server_addr().to_ip().map_or(port, |address| address.port());
    Console::Normal.print(&format!("http://127.0.0.1:{port} shows {}; Ctrl-C ends it", run.display()));
    let mut pictures = Pictures::new(run);
    for request in server.incoming_requests() {
        let answer = answer(&request, run, port, &mut pictures);
        // A browser that has gone needs no answer.
        let _reader_gone = request.respond(answer);
    }
    Ok(())
}

fn answer(request: &Request, run: &Path, port: u16, pictures: &mut Pictures) -> Answer {
    let host = request.headers().iter().find(|header| header.field.equiv("Host"));
    let names = [format!("127.0.0.1:{port}"), format!("localhost:{port}")];
    let is_local = host.is_some_and(|host| names.iter().any(|name| host.value.as_str() == name));
    if !is_local || *request.method() != Method::Get {
        return text("only requests from this machine are answered", 403);
    }
    let (path, query) = request.url().split_once('?').unwrap_or((request.url(), ""));
    match path {
        "/" => data(PAGE.as_bytes().to_vec(), "text/html; charset=utf-8", 200),
        "/state.json" => match LiveState::read(run) {
            Ok(state) => data(serde_json::to_vec(&state).unwrap_or_default(), "application/json", 200),
            Err(error) => text(&error.to_string(), 404),
        },
        "/picture.png" => {
            let field = query.split('&').find_map(|part| part.strip_prefix("field="));
            match field.unwrap_or(Field::Speed.name()).parse::<Field>() {
                Ok(field) => pictures.draw(field),
                Err(_) => text("no such field", 404),
            }
        }
        _ => text("no such page", 404),
    }
}

fn text(what: &str, status: u16) -> Answer {
    data(what.as_bytes().to_vec(), "text/plain; charset=utf-8", status)
}

fn data(bytes: Vec<u8>, kind: &str, status: u16) -> Answer {
    let answer = Response::from_data(bytes).with_status_code(StatusCode(status));
    let headers = [("Content-Type", kind), ("Cache-Control", "no-store")];
    let headers = headers.iter().filter_map(|(name, value)| Header::from_bytes(*name, *value).ok());
    headers.fold(answer, Response::with_header)
}

/// Pictures of the last frame, drawn again when there is a new one.
struct Pictures {
    run: PathBuf,
    /// Field, number of frames and picture drawn last.
    last: Option<(Field, usize, Vec<u8>)>,
}

impl Pictures {
    fn new(run: &Path) -> Self {
        Self { run: run.to_owned(), last: None }
    }

    fn draw(&mut self, field: Field) -> Answer {
        match self.drawn(field) {
            Ok(bytes) => data(bytes, "image/png", 200),
            Err(error) => text(&error.to_string(), 404),
        }
    }

    fn drawn(&mut self, field: Field) -> Result<Vec<u8>, OutputError> {
        let results = Results::open(&self.run)?;
        if let Some((known, frames, bytes)) = &self.last
            && (*known, *frames) == (field, results.len())
        {
            return Ok(bytes.clone());
        }
        let path = std::env::temp_dir().join(format!("sphecs-watch-{}.png", std::process::id()));
        let options = RenderOptions { field, width: WIDTH, ..RenderOptions::default() };
        picture::render(&results, None, &options, &path)?;
        let read = std::fs::read(&path);
        // What stays there is small, and of no use to anyone.
        let _gone = std::fs::remove_file(&path);
        let bytes = read.map_err(|cause| OutputError::Io { path, doing: "read", cause })?;
        self.last = Some((field, results.len(), bytes.clone()));
        Ok(bytes)
    }
}
