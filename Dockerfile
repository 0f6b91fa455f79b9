# Images of Treeline. The last stage, `server`, is what is built without
# --target; docker-compose.yml uses the others too (docs/how-to/deploy.md).
#
#   docker build -t treeline-server .
#   docker build -t treeline-tools --target tools .
#
# Nothing is pulled but Debian. What the programs link decides which packages
# their images hold.
ARG DEBIAN=docker.io/library/debian:bookworm-slim

# -----------------------------------------------------------------------------
FROM ${DEBIAN} AS build
WORKDIR /src
# First what changes seldom, so that its layer is kept.
COPY scripts/packages.txt scripts/install-deps scripts/
COPY scripts/lib/common.sh scripts/lib/
RUN scripts/install-deps && rm -rf /var/lib/apt/lists/*
COPY . .
RUN scripts/build release treeline treeline-server treeline-client \
      treeline-agent && \
    deploy/collect-programs build/release/bin /out

# -----------------------------------------------------------------------------
# What builds web pages. Without npm's registry there are none. Where a proxy
# signs for it, NODE_EXTRA_CA_CERTS is a file with its authority, in this stage.
FROM build AS web
ARG NODE_EXTRA_CA_CERTS=
ENV NODE_EXTRA_CA_CERTS=$NODE_EXTRA_CA_CERTS
RUN apt-get update -q && \
    DEBIAN_FRONTEND=noninteractive \
      apt-get install -q -y --no-install-recommends nodejs npm && \
    rm -rf /var/lib/apt/lists/*

# -----------------------------------------------------------------------------
# The AR page of the server.
FROM web AS ar-page
RUN scripts/build-ar-page --out /out/ar-page || mkdir -p /out/ar-page

# -----------------------------------------------------------------------------
# The page of the robot's operator.
FROM web AS operator-page
RUN scripts/build-page --out /out/page || mkdir -p /out/page

# -----------------------------------------------------------------------------
# Draws what Prometheus has.
FROM web AS dashboard
RUN scripts/build-dashboard --out /out/dashboard || mkdir -p /out/dashboard

# -----------------------------------------------------------------------------
# The templates of report pages. Without them reports are data alone.
FROM web AS report
RUN scripts/build-report --out /out/report || mkdir -p /out/report
RUN scripts/build-bench-report --out /out/report || true

# -----------------------------------------------------------------------------
# A user without rights, the same number in all images, so that they can share
# volumes; and what runs as it.
FROM ${DEBIAN} AS base
COPY deploy/left-out-files /etc/dpkg/dpkg.cfg.d/treeline
COPY deploy/http-ok deploy/install-packages /usr/local/bin/
RUN groupadd --system --gid 10001 treeline && \
    useradd --system --uid 10001 --gid treeline --home-dir /nonexistent \
            --no-create-home --shell /usr/sbin/nologin treeline && \
    install -d -o treeline -g treeline \
      /models /cache /demo /demo/models /tls /state
STOPSIGNAL SIGTERM
LABEL org.opencontainers.image.title="Treeline" \
      org.opencontainers.image.description="Tells a camera where it is" \
      org.opencontainers.image.vendor="The Treeline authors" \
      org.opencontainers.image.version="0.1.0" \
      org.opencontainers.image.base.name="docker.io/library/debian:bookworm-slim"

# -----------------------------------------------------------------------------
# Learns scenes and measures: not on a server. COLMAP is a program that
# `treeline learn` runs for photographs and videos, heif-convert one for those
# that are HEIC; nothing links them.
FROM base AS tools
COPY --from=build /out/packages-tools.txt /usr/share/treeline/
RUN apt-get update -q && \
    xargs -a /usr/share/treeline/packages-tools.txt \
      env DEBIAN_FRONTEND=noninteractive \
      apt-get install -q -y --no-install-recommends colmap \
        libheif-examples && \
    apt-get clean && rm -rf /var/lib/apt/lists/*
COPY --from=build /src/server/models /usr/share/treeline/models
COPY --from=build /out/treeline /out/treeline-client /usr/local/bin/
COPY --from=report /out/report/ /usr/local/share/treeline/
COPY deploy/make-demo deploy/ask-demo /usr/local/bin/
USER 10001:10001
ENTRYPOINT ["treeline"]
CMD ["--help"]

# -----------------------------------------------------------------------------
# Spreads HTTP/2 over servers, and shows browsers the AR page over TLS.
FROM base AS balancer
RUN install-packages haproxy openssl
COPY deploy/make-certificates deploy/run-balancer /usr/local/bin/
COPY deploy/haproxy.cfg /etc/haproxy/haproxy.cfg
USER 10001:10001
# haproxy's word for "finish what runs": SIGTERM would end it at once.
STOPSIGNAL SIGUSR1
EXPOSE 50050 8443 8088 8404
HEALTHCHECK --interval=5s --timeout=3s --start-period=10s \
  CMD ["http-ok", "127.0.0.1", "8404", "/healthz"]
ENTRYPOINT ["run-balancer"]

# -----------------------------------------------------------------------------
FROM base AS prometheus
RUN install-packages prometheus && \
    install -d -o treeline -g treeline /prometheus
COPY deploy/prometheus.yml deploy/observability/rules.yml /etc/prometheus/
COPY --from=dashboard /out/dashboard/ /usr/local/share/treeline/dashboard/
COPY deploy/observability/dashboard.json /usr/local/share/treeline/dashboard/
USER 10001:10001
EXPOSE 9090
HEALTHCHECK --interval=5s --timeout=3s --start-period=10s \
  CMD ["http-ok", "127.0.0.1", "9090", "/-/ready"]
ENTRYPOINT ["prometheus"]
CMD ["--config.file=/etc/prometheus/prometheus.yml", \
     "--storage.tsdb.path=/prometheus", "--storage.tsdb.retention.size=512MB", \
     "--enable-feature=exemplar-storage", \
     "--web.user-assets=/usr/local/share/treeline/dashboard", \
     "--web.listen-address=0.0.0.0:9090"]

# -----------------------------------------------------------------------------
# The robot's program and its page. As with the server, it listens on loopback
# unless it is told otherwise: who reaches it can drive the robot.
FROM base AS agent
COPY --from=build /out/packages-agent.txt /usr/share/treeline/
RUN xargs -a /usr/share/treeline/packages-agent.txt \
      install-packages ca-certificates
COPY --from=build /out/treeline-agent /usr/local/bin/
COPY --from=operator-page /out/page/ /usr/local/share/treeline/page/
USER 10001:10001
EXPOSE 50061 8081
HEALTHCHECK --interval=5s --timeout=3s --start-period=60s \
  CMD ["http-ok", "127.0.0.1", "8081", "/readyz"]
ENTRYPOINT ["treeline-agent"]
CMD ["--help"]

# -----------------------------------------------------------------------------
# A place that a simulated robot knows: a drive, and what comes of it.
FROM build AS cafe
RUN PATH=/out:$PATH deploy/make-robot-demo /out/cafe

# -----------------------------------------------------------------------------
FROM agent AS robot-demo
USER root
RUN install-packages curl jq
COPY --from=cafe /out/cafe/ /usr/local/share/treeline/cafe/
COPY deploy/kidnap-robot deploy/place-model /usr/local/bin/
USER 10001:10001

# -----------------------------------------------------------------------------
# What serves. Without arguments it listens on loopback, inside the container:
# give it certificates and an address, or say that it may be insecure.
FROM base AS server
COPY --from=build /out/packages-server.txt /usr/share/treeline/
RUN xargs -a /usr/share/treeline/packages-server.txt \
      install-packages ca-certificates
COPY --from=build /out/treeline-server /out/treeline-client /usr/local/bin/
COPY --from=ar-page /out/ar-page/ /usr/local/share/treeline/ar-page/
USER 10001:10001
EXPOSE 50051 50052 8080
HEALTHCHECK --interval=10s --timeout=6s --start-period=60s \
  CMD ["treeline-server", "healthcheck", "--server", "127.0.0.1:50051"]
ENTRYPOINT ["treeline-server"]
CMD ["--models", "/models"]
