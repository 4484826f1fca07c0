//! Encrypted connections, by the feature `tls`: rustls with ring, 23 packages.

use super::context::{BrokerStream, PublishError};
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, ServerName};
use rustls::{ClientConfig, ClientConnection, RootCertStore, StreamOwned};
use std::net::TcpStream;
use std::path::Path;
use std::sync::Arc;

/// A stream to the broker `host`, whose certificate one of the authorities in `ca_file` has signed.
pub(super) fn to_broker(
    host: &str,
    socket: TcpStream,
    ca_file: Option<&Path>,
) -> Result<Box<dyn BrokerStream>, PublishError> {
    let refuse = |sentence: String| PublishError::Refused(sentence);
    let ca_file = ca_file.ok_or_else(|| refuse("a `ca_file` belongs to it, in a file of addresses".to_owned()))?;
    let mut roots = RootCertStore::empty();
    for certificate in certificates(ca_file)? {
        roots.add(certificate).map_err(|error| refuse(format!("{}: {error}", ca_file.display())))?;
    }
    let name = ServerName::try_from(host.to_owned()).map_err(|error| refuse(format!("{host}: {error}")))?;
    let config = ClientConfig::builder().with_root_certificates(roots).with_no_client_auth();
    let connection = ClientConnection::new(Arc::new(config), name).map_err(|error| refuse(error.to_string()))?;
    Ok(Box::new(StreamOwned::new(connection, socket)))
}

fn certificates(ca_file: &Path) -> Result<Vec<CertificateDer<'static>>, PublishError> {
    let read = CertificateDer::pem_file_iter(ca_file).and_then(Iterator::collect);
    read.map_err(|error| PublishError::Refused(format!("{}: {error}", ca_file.display())))
}
