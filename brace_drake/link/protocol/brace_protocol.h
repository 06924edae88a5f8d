/* Messages between a host and a brace; PROTOCOL.md says what they do.
 * Made by tools/write_protocol.py from the definition: do not edit.
 *
 * All numbers are little-endian, as on the machines this header is for. Set
 * BRACE_STAGES to the number of moving rings before including it.
 */
#ifndef BRACE_PROTOCOL_H
#define BRACE_PROTOCOL_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifndef BRACE_STAGES
#define BRACE_STAGES 1
#endif

#define BRACE_VERSION 1
#define BRACE_MAX_STAGES 3
#define BRACE_LONGEST_FRAME 486
#define BRACE_NUM_LIMITS 11

#define BRACE_HELLO_REQUEST 0x01
#define BRACE_HELLO 0x02
#define BRACE_GEOMETRY 0x03
#define BRACE_DEVICE_LIMITS 0x04
#define BRACE_LIMITS 0x05
#define BRACE_LIMITS_ECHO 0x06
#define BRACE_STATE 0x10
#define BRACE_COMMAND 0x11
#define BRACE_HEARTBEAT 0x12
#define BRACE_ARM 0x13
#define BRACE_DISARM 0x14
#define BRACE_STOP 0x15
#define BRACE_CLEAR 0x16
#define BRACE_ANSWER 0x17
#define BRACE_FAULT 0x18

/* What a device must refuse: limits below or above. */
#define BRACE_LEG_FORCE_LEAST 1.0f
#define BRACE_LEG_FORCE_MOST 200.0f
#define BRACE_LEG_FORCE_RATE_LEAST 100.0f
#define BRACE_LEG_FORCE_RATE_MOST 50000.0f
#define BRACE_LEG_SHORTEST_LEAST 0.05f
#define BRACE_LEG_SHORTEST_MOST 0.4f
#define BRACE_LEG_LONGEST_LEAST 0.05f
#define BRACE_LEG_LONGEST_MOST 0.4f
#define BRACE_LEG_SPEED_LEAST 0.001f
#define BRACE_LEG_SPEED_MOST 0.5f
#define BRACE_PAD_FORCE_LEAST 1.0f
#define BRACE_PAD_FORCE_MOST 200.0f
#define BRACE_PAD_PRELOAD_LEAST 0.1f
#define BRACE_PAD_PRELOAD_MOST 50.0f
#define BRACE_TOTAL_FORCE_LEAST 1.0f
#define BRACE_TOTAL_FORCE_MOST 500.0f
#define BRACE_WATCHDOG_LEAST 0.005f
#define BRACE_WATCHDOG_MOST 1.0f
#define BRACE_RELEASE_TIME_LEAST 0.05f
#define BRACE_RELEASE_TIME_MOST 2.0f
#define BRACE_RELEASE_DAMPING_LEAST 1.0f
#define BRACE_RELEASE_DAMPING_MOST 100.0f

/* What feeds the watchdog, and what the session. */
#define BRACE_FEEDS_WATCHDOG(t) ( \
  (t) == BRACE_COMMAND)
#define BRACE_FEEDS_SESSION(t) ( \
  (t) == BRACE_LIMITS || \
  (t) == BRACE_COMMAND || \
  (t) == BRACE_HEARTBEAT || \
  (t) == BRACE_ARM || \
  (t) == BRACE_DISARM || \
  (t) == BRACE_STOP || \
  (t) == BRACE_CLEAR)

/* What has to be newer than all of these that have come. */
#define BRACE_IS_ORDERED(t) ( \
  (t) == BRACE_LIMITS || \
  (t) == BRACE_COMMAND || \
  (t) == BRACE_ARM || \
  (t) == BRACE_CLEAR || \
  (t) == BRACE_DISARM || \
  (t) == BRACE_STOP)
#define BRACE_SOON_US 10000000u

enum brace_state_code {
  BRACE_STATE_BOOT = 0, /* self-test; silent, but for noise; drives released */
  BRACE_STATE_HELLO = 1, /* waits for a host's hello and limits; drives released */
  BRACE_STATE_DISARMED = 2, /* limits agreed, states are sent; drives released */
  BRACE_STATE_ARMED = 3, /* follows commands; the watchdog runs */
  BRACE_STATE_STOPPED = 4, /* latched stop with its cause; drives released */
  BRACE_STATE_FAULT = 5, /* e-stop or drive fault; drives without power */
};

enum brace_cause_code {
  BRACE_CAUSE_NONE = 0, /* none */
  BRACE_CAUSE_HOST_STOP = 1, /* the host sent a stop */
  BRACE_CAUSE_STOP_KEY = 2, /* the operator's stop key */
  BRACE_CAUSE_WATCHDOG = 3, /* no accepted command within the watchdog's period */
  BRACE_CAUSE_ESTOP = 4, /* the emergency stop is pressed */
  BRACE_CAUSE_DRIVE_FAULT = 5, /* a drive reports a fault */
  BRACE_CAUSE_LEG_STROKE = 6, /* a leg is shorter or longer than allowed */
  BRACE_CAUSE_LEG_SPEED = 7, /* a leg is faster than allowed */
  BRACE_CAUSE_PAD_FORCE = 8, /* the force of a pad is above its limit */
  BRACE_CAUSE_TOTAL_FORCE = 9, /* the sum of the rings' forces is above its limit */
  BRACE_CAUSE_RING_POSE = 10, /* a ring is displaced or turned further than allowed */
  BRACE_CAUSE_TRACKING = 11, /* a ring is further from its virtual pose than allowed */
  BRACE_CAUSE_STALE_DATA = 12, /* the newest reading is older than allowed */
  BRACE_CAUSE_LOST_MESSAGES = 13, /* more messages in a row are lost than allowed */
  BRACE_CAUSE_JUMP = 14, /* a reading changes from one tick to the next as none can */
  BRACE_CAUSE_DISAGREEMENT = 15, /* force reading and leg forces disagree for too long */
  BRACE_CAUSE_STUCK_LEG = 16, /* a leg's reading stands still while others travel */
  BRACE_CAUSE_BAD_COMMAND = 17, /* a command holds a value that is no finite number */
  BRACE_CAUSE_NO_POSE = 18, /* no ring pose fits the leg lengths */
  BRACE_CAUSE_DISCONNECTED = 19, /* the port is gone */
  BRACE_CAUSE_HOST_ERROR = 20, /* the host's control law failed */
  BRACE_CAUSE_DISARMED = 21, /* the device left ARMED, and its host had not asked for it */
};

enum brace_flag_code {
  BRACE_FLAG_CLAMPED = 1, /* the command was cut at a limit of force or rate */
  BRACE_FLAG_ESTOP = 2, /* the emergency stop is pressed now */
  BRACE_FLAG_MARKER = 4, /* `marker` holds a measurement */
  BRACE_FLAG_NO_NEW_COMMAND = 8, /* the last tick began without a new command */
  BRACE_FLAG_RELEASING = 16, /* the release has not ended yet */
};

enum brace_mode_code {
  BRACE_MODE_FORCE = 0, /* leg forces, N; positive pushes the anchors apart */
  BRACE_MODE_LENGTH = 1, /* leg lengths, m; optional, see `capabilities` of hello */
};

enum brace_reason_code {
  BRACE_REASON_ACCEPTED = 0, /* the request was carried out */
  BRACE_REASON_WRONG_STATE = 1, /* not in this state */
  BRACE_REASON_WRONG_SESSION = 2, /* sealed for another session */
  BRACE_REASON_ESTOP_PRESSED = 3, /* the emergency stop is pressed */
  BRACE_REASON_CAUSE_PRESENT = 4, /* what made the stop is still there */
  BRACE_REASON_LIMIT_TOO_WIDE = 5, /* a limit is wider than the device's own */
  BRACE_REASON_BAD_VALUE = 6, /* a value is no finite number, or makes no sense */
  BRACE_REASON_NOT_SUPPORTED = 7, /* the device cannot do that */
  BRACE_REASON_REPLAYED = 8, /* not newer than what has come in this session */
};

#pragma pack(push, 1)

/* in front of every payload */
struct brace_header {
  uint8_t version; /* of this protocol */
  uint8_t type; /* code of the message */
  uint16_t sequence; /* of this sender, one up with each message */
  uint64_t time_us; /* the sender's clock, never back, us */
};

/* Asks who is there. Answered in every state but BOOT. */
struct brace_hello_request {
  uint32_t nonce; /* any number */
};

/* Says who the device is and what it measures. */
struct brace_hello {
  uint32_t nonce; /* of the request */
  char model[16]; /* kind of device */
  char identity[16]; /* serial number */
  char firmware[16]; /* version */
  char units[16]; /* "m N s rad" */
  uint8_t stages; /* S: S rings move, 6 S legs */
  uint8_t state; /* see states */
  uint8_t capabilities; /* bit 0: commands of length */
  float rate_hz; /* of ticks, and so of states, Hz */
  float length_resolution; /* of leg lengths, m */
  float force_resolution; /* of forces, N */
  float force_range; /* full scale of forces, N */
};

/* The geometry that the device was calibrated to; follows HELLO. */
struct brace_geometry {
  float rest[3 * BRACE_STAGES]; /* of each ring's origin, W, m */
  float lower[18 * BRACE_STAGES]; /* lower anchors, lower ring, m */
  float upper[18 * BRACE_STAGES]; /* upper anchors, upper ring, m */
};

/* The widest limits that the device accepts; follows GEOMETRY. */
struct brace_device_limits {
  float leg_force; /* command of a leg, N */
  float leg_force_rate; /* change of the command, N/s */
  float leg_shortest[BRACE_STAGES]; /* length of a leg, m */
  float leg_longest[BRACE_STAGES]; /* length of a leg, m */
  float leg_speed; /* rate of a leg, m/s */
  float pad_force; /* of the pad that presses more, N */
  float pad_preload; /* on both pads at rest, as the pad's force is found with it, N */
  float total_force; /* sum of |F| of all rings, N */
  float watchdog; /* longest wait for a command, s */
  float release_time; /* from a stop to no force, s */
  float release_damping; /* of a released leg, N s/m */
};

/* The limits that shall hold; sealed with the session 0. */
struct brace_limits {
  float leg_force; /* command of a leg, N */
  float leg_force_rate; /* change of the command, N/s */
  float leg_shortest[BRACE_STAGES]; /* length of a leg, m */
  float leg_longest[BRACE_STAGES]; /* length of a leg, m */
  float leg_speed; /* rate of a leg, m/s */
  float pad_force; /* of the pad that presses more, N */
  float pad_preload; /* on both pads at rest, as the pad's force is found with it, N */
  float total_force; /* sum of |F| of all rings, N */
  float watchdog; /* longest wait for a command, s */
  float release_time; /* from a stop to no force, s */
  float release_damping; /* of a released leg, N s/m */
  uint32_t seal; /* CRC-32 of all before it, begun at the session */
};

/* The limits that hold now. The host compares them bit by bit. */
struct brace_limits_echo {
  uint8_t reason; /* see reasons */
  uint8_t index; /* of the refused limit, from 0 */
  uint32_t session; /* new and not 0; 0 where refused */
  float leg_force; /* command of a leg, N */
  float leg_force_rate; /* change of the command, N/s */
  float leg_shortest[BRACE_STAGES]; /* length of a leg, m */
  float leg_longest[BRACE_STAGES]; /* length of a leg, m */
  float leg_speed; /* rate of a leg, m/s */
  float pad_force; /* of the pad that presses more, N */
  float pad_preload; /* on both pads at rest, as the pad's force is found with it, N */
  float total_force; /* sum of |F| of all rings, N */
  float watchdog; /* longest wait for a command, s */
  float release_time; /* from a stop to no force, s */
  float release_damping; /* of a released leg, N s/m */
};

/* Readings of one tick; sent each tick while there is a session. */
struct brace_state {
  uint8_t state; /* see states */
  uint8_t cause; /* see causes */
  uint16_t flags; /* see flags */
  uint32_t tick; /* counts control ticks, modulo 2^32 */
  uint16_t command; /* sequence of the command in use */
  uint16_t rejected; /* messages refused so far, modulo 2^16 */
  float leg_length[6 * BRACE_STAGES]; /* of each leg, m */
  float force[3 * BRACE_STAGES]; /* of each ring on the torso, W, N */
  float marker[3]; /* on the torso, from rest, W, m */
};

/* What the legs shall do from this tick on. */
struct brace_command {
  uint8_t mode; /* see modes */
  uint32_t tick; /* of the state that it answers */
  float values[6 * BRACE_STAGES]; /* of each leg, N or m */
  uint32_t seal; /* CRC-32 of all before it, begun at the session */
};

/* Keeps the session; the device answers each, for the clocks. */
struct brace_heartbeat {
  uint64_t echo_us; /* time_us of the heartbeat answered, us */
};

/* Lets the drives follow commands. */
struct brace_arm {
  uint32_t nonce; /* any number */
  uint32_t seal; /* CRC-32 of all before it, begun at the session */
};

/* Releases the drives without a latched stop. */
struct brace_disarm {
  uint32_t nonce; /* any number */
};

/* Releases the drives and latches. Needs neither seal nor session. */
struct brace_stop {
  uint8_t cause; /* see causes */
};

/* Ends a latched stop where its cause has gone; to DISARMED. */
struct brace_clear {
  uint8_t cause; /* the one that was latched */
  uint32_t seal; /* CRC-32 of all before it, begun at the session */
};

/* Answers ARM, DISARM, STOP and CLEAR. */
struct brace_answer {
  uint8_t request; /* code of the message answered */
  uint16_t sequence_answered; /* its sequence */
  uint8_t reason; /* see reasons */
  uint8_t state; /* after it, see states */
};

/* Sent once, when a stop latches. */
struct brace_fault {
  uint8_t state; /* STOPPED or FAULT */
  uint8_t cause; /* see causes */
  uint8_t index; /* of the leg or ring, from 0 */
  float value; /* what was measured */
  float limit; /* what is allowed */
};

#pragma pack(pop)

static inline size_t brace_payload_size(uint8_t type) {
  switch (type) {
    case BRACE_HELLO_REQUEST: return sizeof(struct brace_hello_request);
    case BRACE_HELLO: return sizeof(struct brace_hello);
    case BRACE_GEOMETRY: return sizeof(struct brace_geometry);
    case BRACE_DEVICE_LIMITS: return sizeof(struct brace_device_limits);
    case BRACE_LIMITS: return sizeof(struct brace_limits);
    case BRACE_LIMITS_ECHO: return sizeof(struct brace_limits_echo);
    case BRACE_STATE: return sizeof(struct brace_state);
    case BRACE_COMMAND: return sizeof(struct brace_command);
    case BRACE_HEARTBEAT: return sizeof(struct brace_heartbeat);
    case BRACE_ARM: return sizeof(struct brace_arm);
    case BRACE_DISARM: return sizeof(struct brace_disarm);
    case BRACE_STOP: return sizeof(struct brace_stop);
    case BRACE_CLEAR: return sizeof(struct brace_clear);
    case BRACE_ANSWER: return sizeof(struct brace_answer);
    case BRACE_FAULT: return sizeof(struct brace_fault);
    default: return 0;
  }
}

static inline uint16_t brace_crc16(const uint8_t *data, size_t size) {
  uint16_t crc = 0xFFFF;
  for (size_t i = 0; i < size; ++i) {
    crc ^= (uint16_t)(data[i] << 8);
    for (int bit = 0; bit < 8; ++bit)
      crc = (uint16_t)(crc & 0x8000 ? (crc << 1) ^ 0x1021 : crc << 1);
  }
  return crc;
}

/* The seal: CRC-32 (reflected 0xEDB88320) begun at the session's number. */
static inline uint32_t brace_seal(const uint8_t *data, size_t size,
                                  uint32_t session) {
  uint32_t crc = ~session;
  for (size_t i = 0; i < size; ++i) {
    crc ^= data[i];
    for (int bit = 0; bit < 8; ++bit)
      crc = crc & 1 ? (crc >> 1) ^ 0xEDB88320u : crc >> 1;
  }
  return ~crc;
}

/* The newest message that has come in a session. */
struct brace_newest {
  uint16_t sequence;
  uint64_t time_us;
};

/* Whether a message may count, by PROTOCOL.md, "Newer"; it is remembered then.
 * Call it once for each message that BRACE_IS_ORDERED, if it has no seal or its
 * seal fits, before anything else is judged. Answer REPLAYED if it says 0, but
 * obey DISARM and STOP all the same. Session 0: none has begun. */
static inline int brace_is_newer(struct brace_newest *newest,
                                 const struct brace_header *header,
                                 uint32_t session) {
  uint16_t ahead = (uint16_t)(header->sequence - newest->sequence);
  int is_newer = 1;
  if (session != 0) {
    if (header->time_us < newest->time_us)
      is_newer = 0;
    else if (header->time_us - newest->time_us <= BRACE_SOON_US)
      is_newer = ahead > 0 && ahead < 0x8000;
  }
  if (is_newer) {
    newest->sequence = header->sequence;
    newest->time_us = header->time_us;
  }
  return is_newer;
}

/* Writes the stuffed bytes, at most size + size / 254 + 1; returns how many. */
static inline size_t brace_stuff(const uint8_t *data, size_t size,
                                 uint8_t *out) {
  size_t code_at = 0, at = 1;
  uint8_t code = 1;
  for (size_t i = 0; i < size; ++i) {
    if (data[i] != 0) {
      out[at++] = data[i];
      ++code;
    }
    if (data[i] == 0 || (code == 0xFF && i + 1 < size)) {
      out[code_at] = code;
      code_at = at++;
      code = 1;
    }
  }
  out[code_at] = code;
  return at;
}

/* Undoes brace_stuff; out has room for size bytes. 0: codes do not fit. */
static inline size_t brace_unstuff(const uint8_t *data, size_t size,
                                   uint8_t *out) {
  size_t at = 0, written = 0;
  while (at < size) {
    uint8_t code = data[at++];
    if (code == 0 || at + code - 1 > size) return 0;
    for (uint8_t i = 1; i < code; ++i) out[written++] = data[at++];
    if (code < 0xFF && at < size) out[written++] = 0;
  }
  return written;
}

/* Makes a frame with its delimiters; `body` is header and payload. The room
 * needed is BRACE_LONGEST_FRAME for both arrays. Returns the frame's size. */
static inline size_t brace_make_frame(const uint8_t *body, size_t size,
                                      uint8_t *frame) {
  uint8_t checked[BRACE_LONGEST_FRAME];
  uint16_t crc = brace_crc16(body, size);
  memcpy(checked, body, size);
  checked[size] = (uint8_t)(crc & 0xFF);
  checked[size + 1] = (uint8_t)(crc >> 8);
  frame[0] = 0;
  size_t length = brace_stuff(checked, size + 2, frame + 1);
  frame[length + 1] = 0;
  return length + 2;
}

/* Takes what lay between two delimiters apart. Returns the size of header and
 * payload in `body`, or 0 for anything that is not exactly a message. */
static inline size_t brace_open_frame(const uint8_t *chunk, size_t size,
                                      uint8_t *body) {
  struct brace_header header;
  if (size > BRACE_LONGEST_FRAME) return 0;
  size_t length = brace_unstuff(chunk, size, body);
  if (length < sizeof header + 2) return 0;
  length -= 2;
  uint16_t sent = (uint16_t)(body[length] | (body[length + 1] << 8));
  if (brace_crc16(body, length) != sent) return 0;
  memcpy(&header, body, sizeof header);
  size_t payload = brace_payload_size(header.type);
  if (header.version != BRACE_VERSION || payload == 0) return 0;
  return length == sizeof header + payload ? length : 0;
}

#endif /* BRACE_PROTOCOL_H */
