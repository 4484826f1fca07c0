//! Options of a log that is published, and its outputs and live page while it runs.

use std::net::{IpAddr, Ipv4Addr};
use std::sync::Arc;

use crate::options::MountingArguments;
use crate::output::{Failure, complain};
use anemometry::head::Head;
use publish::commands::FeedCommands;
use publish::feed::Feed;
use publish::listen::{Listening, Token};
use publish::output::{PublishContext, Publishing};
use publish::page::LivePage;
use publish::target::PublishTarget;
use recording::head_mounting::HeadMounting;

#[derive(clap::Args)]
pub struct PublishArguments {
    /// Send rows to other programs: nmea+udp://HOST:PORT, gill+tcp:, mqtt:, scpi:, or a .toml
    /// file of such addresses. May be repeated.
    #[arg(long, value_name = "ADDRESS|FILE")]
    publish: Vec<String>,
    /// Serve the live page at this port, 0 for any that is free, and print its address.
    #[arg(long, value_name = "PORT")]
    page: Option<u16>,
    /// Let other machines reach listeners at this address of this one.
    #[arg(long, value_name = "IP")]
    listen: Option<IpAddr>,
    /// Token that a client says before it may command; without, one is made and printed.
    #[arg(long, value_name = "TOKEN", env = "ANEMO_TOKEN", hide_env_values = true)]
    token: Option<String>,
    #[command(flatten)]
    mounting: MountingArguments,
}

impl PublishArguments {
    /// Targets to publish to, before anything runs.
    pub fn targets(&self) -> Result<Vec<PublishTarget>, Failure> {
        let all = self.publish.iter().map(|argument| publish::targets(argument)).collect::<Result<Vec<_>, _>>();
        Ok(all.map_err(Failure::usage)?.into_iter().flatten().collect())
    }

    /// Mounts a head as the options have it.
    pub fn mount(&self, head: &mut Head) -> Result<(), Failure> {
        head.heading_deg = self.mounting.heading.or(head.heading_deg);
        head.up = self.mounting.up()?.or(head.up);
        HeadMounting::new(head.heading_deg.unwrap_or(0.0), head.up).map_err(Failure::usage)?;
        Ok(())
    }

    /// Starts it.
    pub fn start(&self, targets: &[PublishTarget], feed: &Feed, commands: &FeedCommands) -> Result<Published, Failure> {
        let token = match &self.token {
            Some(token) => Token::new(token).map_err(Failure::usage)?,
            None => Token::random().map_err(Failure::work)?,
        };
        if self.token.is_none() && targets.iter().any(PublishTarget::takes_commands) {
            complain(&format!("commands need the token {}", token.text()));
        }
        let listening = Listening::new(self.listen, token);
        let serve = |port: u16| {
            let address = (self.listen.unwrap_or(Ipv4Addr::LOCALHOST.into()), port).into();
            LivePage::serve(feed, Some(commands.clone()), &listening, address)
        };
        let page = self.page.map(serve).transpose().map_err(Failure::work)?;
        if let Some(page) = &page {
            complain(&format!("live at {}", page.address()));
        }
        let context = PublishContext { listening, commands: Some(commands.clone()), report: Arc::new(complain) };
        let outputs = publish::start(targets, feed, &context).map_err(Failure::work)?;
        Ok(Published { outputs, page })
    }
}

/// Outputs that publish, until the feed is gone.
pub struct Published {
    outputs: Publishing,
    page: Option<LivePage>,
}

impl Published {
    /// Waits until all have said good-bye.
    pub fn end(self) {
        drop(self.page);
        for name in self.outputs.join() {
            complain(&format!("{name} has not taken the end of the log"));
        }
    }
}
