/* The least a master can do in a cycle, in C on SOEM: the yardstick of 'bench benchmark cycle'.
 *
 * cycle_loop INTERFACE PERIOD_NS CYCLES PRIORITY OUTPUT
 *
 * Wakes at absolute deadlines, sends the process data, waits for it, copies the inputs into a ring, and notes six
 * 64-bit numbers a cycle: slot, when it was due, woke, had its frame back, was done (monotonic clock, ns), working
 * counter. A slot whose whole period has passed is skipped. OUTPUT gets the numbers at the end. PRIORITY 0 leaves the
 * ordinary scheduling. Waits for frames as the bus process does: asleep, two periods at most.
 */
#define _GNU_SOURCE
#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include "ethercat.h"

enum { SLOT, DUE, WOKE, BACK, DONE, WKC, WORDS };
enum { RING_ROWS = 8192, SETTLING_CYCLES = 2000 };

static uint8 image[4096];

/* What SOEM keeps of one network. */
static ecx_portt port;
static ec_slavet slaves[EC_MAXSLAVE];
static int slave_count;
static ec_groupt groups[EC_MAXGROUP];
static uint8 eeprom[EC_MAXEEPBUF];
static uint32 eeprom_map[EC_MAXEEPBITMAP];
static ec_eringt errors;
static ec_idxstackT frames;
static ec_SMcommtypet manager_types[EC_MAX_MAPT];
static ec_PDOassignt assignments[EC_MAX_MAPT];
static ec_PDOdesct descriptions[EC_MAX_MAPT];
static ec_eepromSMt eeprom_managers;
static ec_eepromFMMUt eeprom_fmmus;
static boolean has_error;
static int64 clock_of_slaves;
static ecx_contextt network = {
    .port = &port,
    .slavelist = slaves,
    .slavecount = &slave_count,
    .maxslave = EC_MAXSLAVE,
    .grouplist = groups,
    .maxgroup = EC_MAXGROUP,
    .esibuf = eeprom,
    .esimap = eeprom_map,
    .elist = &errors,
    .idxstack = &frames,
    .ecaterror = &has_error,
    .DCtime = &clock_of_slaves,
    .SMcommtype = manager_types,
    .PDOassign = assignments,
    .PDOdesc = descriptions,
    .eepSM = &eeprom_managers,
    .eepFMMU = &eeprom_fmmus,
};

static int64_t now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

static void sleep_until(int64_t at_ns)
{
    struct timespec at = {at_ns / 1000000000, at_ns % 1000000000};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, NULL) != 0) {
    }
}

static void become_real_time(int priority)
{
    struct sched_param wanted = {.sched_priority = priority};
    if (priority > 0 && (sched_setscheduler(0, SCHED_FIFO, &wanted) != 0 || mlockall(MCL_CURRENT | MCL_FUTURE) != 0)) {
        perror("real-time scheduling");
    }
}

static int bring_up(const char *interface)
{
    if (!ecx_init(&network, interface)) {
        fprintf(stderr, "%s cannot be opened\n", interface);
        return 0;
    }
    if (ecx_config_init(&network, FALSE) < 1) {
        fprintf(stderr, "no slave answers on %s\n", interface);
        return 0;
    }
    ecx_config_map_group(&network, image, 0);
    ecx_configdc(&network);
    ecx_statecheck(&network, 0, EC_STATE_SAFE_OP, 4 * EC_TIMEOUTSTATE);
    for (int i = 0; i < 400; i++) {
        ecx_send_processdata(&network);
        ecx_receive_processdata(&network, EC_TIMEOUTRET);
        if (i % 50 == 0) {
            slaves[0].state = EC_STATE_OPERATIONAL;
            ecx_writestate(&network, 0);
        }
        if (ecx_statecheck(&network, 0, EC_STATE_OPERATIONAL, 2000) == EC_STATE_OPERATIONAL) {
            return 1;
        }
    }
    fprintf(stderr, "the slaves do not reach OPERATIONAL\n");
    return 0;
}

int main(int argc, char **argv)
{
    if (argc != 6) {
        fprintf(stderr, "usage: cycle_loop INTERFACE PERIOD_NS CYCLES PRIORITY OUTPUT\n");
        return 2;
    }
    const int64_t period = atoll(argv[2]), cycles = atoll(argv[3]);
    int64_t *notes = calloc((size_t)cycles * WORDS, sizeof *notes);
    if (notes == NULL || !bring_up(argv[1])) {
        return 1;
    }
    const size_t width = slaves[0].Ibytes;
    uint8 *ring = calloc(RING_ROWS, width);
    if (ring == NULL) {
        return 1;
    }
    become_real_time(atoi(argv[4]));
    struct pollfd frame = {.fd = port.sockhandle, .events = POLLIN};
    fcntl(frame.fd, F_SETFL, fcntl(frame.fd, F_GETFL) | O_NONBLOCK);
    const struct timespec patience = {2 * period / 1000000000, 2 * period % 1000000000};
    const int came_us = (int)(period / 5000);
    uint8 stale[2048];

    const int64_t start = now_ns();
    int64_t slot = -1;
    for (int64_t i = -SETTLING_CYCLES; i < cycles; i++) {
        const int64_t passed = (now_ns() - start) / period;
        slot = slot + 1 > passed ? slot + 1 : passed;
        sleep_until(start + slot * period);
        const int64_t woke = now_ns();
        while (read(frame.fd, stale, sizeof stale) > 0) {
        }
        ecx_send_processdata(&network);
        const int wkc = ecx_receive_processdata(&network, ppoll(&frame, 1, &patience, NULL) > 0 ? came_us : 1);
        const int64_t back = now_ns();
        memcpy(ring + (size_t)((i + SETTLING_CYCLES) % RING_ROWS) * width, slaves[0].inputs, width);
        if (i >= 0) {
            int64_t *row = notes + i * WORDS;
            row[SLOT] = slot;
            row[DUE] = start + slot * period;
            row[WOKE] = woke;
            row[BACK] = back;
            row[DONE] = now_ns();
            row[WKC] = wkc;
        }
    }
    slaves[0].state = EC_STATE_INIT;
    ecx_writestate(&network, 0);
    ecx_close(&network);
    FILE *out = fopen(argv[5], "wb");
    if (out == NULL || fwrite(notes, sizeof *notes * WORDS, (size_t)cycles, out) != (size_t)cycles || fclose(out) != 0) {
        perror(argv[5]);
        return 1;
    }
    return 0;
}
