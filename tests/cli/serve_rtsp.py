#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""An RTSP camera on the loopback interface for tests: serve_rtsp.py PORT_FILE SECONDS.

ffmpeg makes the pictures (H.264, 320x240, 15 Hz) and packs them as RTP; each client gets them within its own
connection (RFC 2326, interleaved), which is how OpenCV asks for them. Writes the port to PORT_FILE, ends after SECONDS.
"""
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading


def start_camera(udp_port, description):
    return subprocess.Popen(["ffmpeg", "-v", "error", "-re", "-f", "lavfi", "-i", "testsrc=size=320x240:rate=15",
                             "-c:v", "libx264", "-preset", "ultrafast", "-tune", "zerolatency", "-g", "5", "-pix_fmt", "yuv420p",
                             "-t", sys.argv[2], "-sdp_file", description, "-f", "rtp", f"rtp://127.0.0.1:{udp_port}"],
                            stdin=subprocess.DEVNULL)


def described(description):
    """What ffmpeg says of the stream, once it has."""
    for _ in range(100):
        if os.path.exists(description) and "a=fmtp" in (text := open(description).read()):
            return text.replace("SDP:\n", "") + "a=control:track\n"
        threading.Event().wait(0.1)
    sys.exit("ffmpeg does not describe its stream")


def forward(packets, connection):
    packets.setblocking(False)
    try:
        while packets.recv(65536):  # what was sent while nobody watched
            pass
    except BlockingIOError:
        packets.setblocking(True)
    while packet := packets.recv(65536):
        try:
            connection.sendall(b"$\0" + len(packet).to_bytes(2, "big") + packet)
        except OSError:
            return


def serve(connection, packets, text):
    lines = connection.makefile("rb")
    while request := lines.readline().split():
        headers = {}
        while line := lines.readline().strip():
            name, _, value = line.decode().partition(":")
            headers[name.lower()] = value.strip()
        method, more, body = request[0].decode(), "", ""
        if method == "OPTIONS":
            more = "Public: OPTIONS, DESCRIBE, SETUP, PLAY, TEARDOWN\r\n"
        elif method == "DESCRIBE":
            more, body = "Content-Type: application/sdp\r\n", text.replace("\n", "\r\n")
        elif method == "SETUP":
            more = "Transport: RTP/AVP/TCP;unicast;interleaved=0-1\r\nSession: 1\r\n"
        answer = f"RTSP/1.0 200 OK\r\nCSeq: {headers.get('cseq', 0)}\r\n{more}Content-Length: {len(body)}\r\n\r\n{body}"
        connection.sendall(answer.encode())
        if method == "PLAY":
            threading.Thread(target=forward, args=(packets, connection), daemon=True).start()
        if method == "TEARDOWN":
            return


def answer_clients(packets, text):
    server = socket.create_server(("127.0.0.1", 0))
    with open(sys.argv[1] + ".new", "w") as file:
        file.write(str(server.getsockname()[1]))
    os.rename(sys.argv[1] + ".new", sys.argv[1])
    server.settimeout(float(sys.argv[2]))
    while True:
        connection, _ = server.accept()
        threading.Thread(target=serve, args=(connection, packets, text), daemon=True).start()


def main():
    packets = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    packets.bind(("127.0.0.1", 0))
    signal.signal(signal.SIGTERM, lambda *_: sys.exit())
    with tempfile.TemporaryDirectory() as folder:
        camera = start_camera(packets.getsockname()[1], f"{folder}/sdp")
        try:
            answer_clients(packets, described(f"{folder}/sdp"))
        except TimeoutError:
            pass
        finally:
            camera.kill()


main()
